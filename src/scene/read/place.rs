//! Places of a tree in a text that the tree's own is a part of.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::Node;

/// Moves all places in a tree.
pub(super) fn shift(tree: &mut DeTable<'_>, place: &impl Fn(usize) -> usize) {
    let members = std::mem::take(tree);
    *tree = members
        .into_iter()
        .map(|(key, mut node)| {
            shift_node(&mut node, place);
            let span = key.span();
            let key = Spanned::new(place(span.start)..place(span.end), key.into_inner());
            (key, node)
        })
        .collect();
}

fn shift_node(node: &mut Node<'_>, place: &impl Fn(usize) -> usize) {
    let span = node.span();
    let nothing = Spanned::new(0..0, DeValue::Boolean(false));
    let mut value = std::mem::replace(node, nothing).into_inner();
    match &mut value {
        DeValue::Table(table) => shift(table, place),
        DeValue::Array(items) => {
            for item in items.iter_mut() {
                shift_node(item, place);
            }
        }
        DeValue::String(_)
        | DeValue::Integer(_)
        | DeValue::Float(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_) => {}
    }
    *node = Spanned::new(place(span.start)..place(span.end), value);
}
