//! Single words out of a scenario's text, and the text with another name: what listing and copying files takes, without reading them
//! as scenarios.

use super::typed::Typed;

/// The text that stands at a key at the top of a file: its name, say.
pub fn text_of(text: &str, key: &str) -> Option<String> {
    Some(Typed::from_text("", text).root.get(key)?.as_text()?.to_owned())
}

/// The text of a file with another name in it, all else as it is, comments too; `None` where it gives no name.
pub fn renamed(text: &str, name: &str) -> Option<String> {
    let typed = Typed::from_text("", text);
    let node = typed.root.get("name").filter(|node| node.as_text().is_some())?;
    let (before, after) = (text.get(..node.span.start)?, text.get(node.span.end..)?);
    Some(format!("{before}\"{name}\"{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_exchanged_and_nothing_else() {
        let text = "\u{feff}# its name = \"a\"\r\nname = 'a'   # not \"b\"\r\nabout = \"name = 1\"\r\n[duct]\r\nname = \"a\"\r\n";
        let expected = text.replace("name = 'a'", "name = \"of-mine\"");
        assert_eq!(renamed(text, "of-mine"), Some(expected));
        assert_eq!(text_of(text, "about"), Some("name = 1".to_owned()));
        for nameless in ["", "about = \"x\"\n", "name = 3\n", "[duct]\nname = \"a\"\n"] {
            assert_eq!(renamed(nameless, "b"), None, "{nameless}");
        }
    }
}
