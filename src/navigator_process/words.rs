//! A command line to words, without a shell: no variables, no patterns, no pipes.

/// What is wrong with a command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WordsError {
    /// There is no word.
    #[error("no program is named")]
    Empty,
    /// A quote is not closed.
    #[error("the quote {0} is not closed")]
    Open(char),
}

/// Words apart by white space. `'…'` and `"…"` keep it, as quotes; there is no other magic, so a backslash is a backslash.
///
/// # Errors
/// Where a quote is not closed.
pub fn words(line: &str) -> Result<Vec<String>, WordsError> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in line.chars() {
        match quote {
            Some(open) if c == open => quote = None,
            Some(_) => word.get_or_insert_default().push(c),
            None if c == '\'' || c == '"' => {
                quote = Some(c);
                // Also where nothing stands between the quotes.
                word.get_or_insert_default();
            }
            None if c.is_whitespace() => words.extend(word.take()),
            None => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    quote.map_or(Ok(words), |open| Err(WordsError::Open(open)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_split_as_typed() {
        let split = |line: &str| words(line).expect("closed");
        assert_eq!(split("python3  a.py\t-x"), ["python3", "a.py", "-x"]);
        assert_eq!(split(r#"'/my dir/nav' --say="two words" ''"#), ["/my dir/nav", "--say=two words", ""]);
        assert_eq!(split(r"C:\nav.exe"), [r"C:\nav.exe"]);
        assert_eq!(split(" "), Vec::<String>::new());
        assert_eq!(words("a 'b"), Err(WordsError::Open('\'')));
    }
}
