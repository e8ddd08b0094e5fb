//! What the window remembers from one time to the next.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Most files that are remembered.
const MOST_RECENT: usize = 12;

/// Where it is kept in the window's storage.
const KEY: &str = "probelight";

/// What is remembered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Files that were opened, the last first.
    pub recent: Vec<PathBuf>,
    /// Whether there are more frames than 60 a second.
    pub runs_free: bool,
    /// Whether frames do not wait for the display.
    pub tears: bool,
}

impl Settings {
    /// What the storage has.
    pub fn load(storage: Option<&dyn eframe::Storage>) -> Self {
        storage.and_then(|storage| eframe::get_value(storage, KEY)).unwrap_or_default()
    }

    /// Gives it to the storage.
    pub fn save(&self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, KEY, self);
    }

    /// A file was opened.
    pub fn opened(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(MOST_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_file_comes_first_and_once() {
        let mut settings = Settings::default();
        for name in ["/a", "/b", "/a"] {
            settings.opened(name.as_ref());
        }
        assert_eq!(settings.recent, [PathBuf::from("/a"), PathBuf::from("/b")]);
        (0..50).for_each(|n| settings.opened(format!("/{n}").as_ref()));
        assert_eq!(settings.recent.len(), MOST_RECENT);
    }
}
