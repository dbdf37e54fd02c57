//! The table of fields as a tree, the form in which files are walked.

use std::sync::OnceLock;

use super::{Default, Field, TableRow, fields, last, parent, tables};

/// What may stand at a key.
#[derive(Debug)]
pub(in crate::scenario) enum Shape {
    Leaf(&'static Field),
    Table(TableShape),
    /// Tables under names that the file chooses.
    Named(TableShape),
    /// An array of tables.
    List(TableShape),
}

/// What may stand in a table: fields first, then tables, each in the order of the rows.
#[derive(Debug)]
pub(in crate::scenario) struct TableShape {
    pub(in crate::scenario) row: &'static TableRow,
    pub(in crate::scenario) children: Vec<(&'static str, Shape)>,
}

/// The shape of a whole file.
pub(in crate::scenario) fn root() -> &'static TableShape {
    static ROOT: OnceLock<TableShape> = OnceLock::new();
    static ROW: TableRow = TableRow::new("", "A run of a robot through a duct.");
    ROOT.get_or_init(|| TableShape::of(&ROW))
}

impl Shape {
    /// Whether the table around it must have it.
    pub(in crate::scenario) fn is_required(&self) -> bool {
        match self {
            Self::Leaf(field) => matches!(field.default, Default::Required(_)),
            Self::Table(inner) => inner.is_required(),
            Self::List(inner) => inner.row.min_len > 0,
            Self::Named(_) => false,
        }
    }
}

impl TableShape {
    fn of(row: &'static TableRow) -> Self {
        let leaves = fields().filter(|f| parent(f.path) == row.path).map(|f| (f.key(), Shape::Leaf(f)));
        let inner = tables().filter_map(|t| {
            let (place, wrap): (_, fn(Self) -> Shape) = match (t.path.strip_suffix("[]"), t.path.strip_suffix(".*")) {
                (Some(place), _) => (place, Shape::List),
                (_, Some(place)) => (place, Shape::Named),
                _ => (t.path, Shape::Table),
            };
            (parent(place) == row.path).then(|| (last(place), wrap(Self::of(t))))
        });
        Self { row, children: leaves.chain(inner).collect() }
    }

    /// What may stand at this key.
    pub(in crate::scenario) fn child(&self, key: &str) -> Option<&Shape> {
        self.children.iter().find(|(name, _)| *name == key).map(|(_, shape)| shape)
    }

    /// Whether a file must have this table, because something in it must be given.
    pub(in crate::scenario) fn is_required(&self) -> bool {
        self.children.iter().any(|(_, child)| child.is_required())
    }

    /// The keys that may stand here.
    pub(in crate::scenario) fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.children.iter().map(|(key, _)| *key)
    }

    /// The fields that may stand here, without those of inner tables.
    pub(in crate::scenario) fn leaves(&self) -> impl Iterator<Item = &'static Field> {
        self.children.iter().filter_map(|(_, shape)| if let Shape::Leaf(field) = shape { Some(*field) } else { None })
    }
}
