//! Undo and redo.

use super::document::Document;
use super::edit::EditKey;

/// Most steps that are kept.
const MOST_STEPS: usize = 200;

/// A document before a step.
#[derive(Clone, Debug)]
struct Step {
    before: Document,
    description: &'static str,
}

/// Documents before and after the present one.
#[derive(Clone, Debug, Default)]
pub struct History {
    past: Vec<Step>,
    future: Vec<Step>,
    /// What the last step is about, while more of it may come.
    open: Option<EditKey>,
}

impl History {
    /// Notes the document before an edit, unless the edit goes on with the last one.
    pub(super) fn note(&mut self, before: &Document, key: Option<EditKey>, description: &'static str) {
        if key.is_some() && key == self.open {
            return;
        }
        self.open = key;
        self.future.clear();
        if self.past.len() == MOST_STEPS {
            self.past.remove(0);
        }
        self.past.push(Step { before: before.clone(), description });
    }

    /// What follows is a step of its own: the mouse was let go.
    pub(super) fn close(&mut self) {
        self.open = None;
    }

    /// Goes back a step. Returns whether there was one.
    pub(super) fn undo(&mut self, document: &mut Document) -> bool {
        self.close();
        swap(&mut self.past, &mut self.future, document)
    }

    /// Goes forward a step. Returns whether there was one.
    pub(super) fn redo(&mut self, document: &mut Document) -> bool {
        self.close();
        swap(&mut self.future, &mut self.past, document)
    }

    /// What would be undone.
    pub fn undoes(&self) -> Option<&'static str> {
        self.past.last().map(|step| step.description)
    }

    /// What would be done again.
    pub fn redoes(&self) -> Option<&'static str> {
        self.future.last().map(|step| step.description)
    }

    /// Number of steps that can be undone.
    pub fn steps(&self) -> usize {
        self.past.len()
    }
}

fn swap(from: &mut Vec<Step>, to: &mut Vec<Step>, document: &mut Document) -> bool {
    let Some(Step { before, description }) = from.pop() else { return false };
    to.push(Step { before: std::mem::replace(document, before), description });
    true
}
