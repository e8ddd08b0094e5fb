//! Baked scene to file.

use std::borrow::Cow;
use std::io::{self, Read, Write};

use crate::BakedScene;
use crate::layout::{MINOR_VERSION, SectionHead, encode_front};
use crate::sections;

impl BakedScene {
    /// Writes the scene as a baked file. The same scene always gives the same bytes.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        write_sections(MINOR_VERSION, &self.sections()?, out)
    }

    /// The sections of the scene's file; arrays are borrowed.
    fn sections(&self) -> io::Result<Vec<(SectionHead, Cow<'_, [u8]>)>> {
        let mut sections = Vec::with_capacity(sections::ALL.len());
        for section in sections::ALL {
            let bytes = (section.encode)(self)?;
            if section.head.is_required() || !bytes.is_empty() {
                sections.push((section.head, bytes));
            }
        }
        Ok(sections)
    }
}

/// Writes header, table and sections.
pub(crate) fn write_sections(
    minor_version: u32,
    sections: &[(SectionHead, Cow<'_, [u8]>)],
    out: &mut impl Write,
) -> io::Result<()> {
    let borrowed: Vec<(SectionHead, &[u8])> =
        sections.iter().map(|(head, bytes)| (*head, &bytes[..])).collect();
    let (front, entries) = encode_front(minor_version, &borrowed);
    out.write_all(&front)?;
    let mut end = front.len() as u64;
    for ((_, bytes), entry) in borrowed.iter().zip(&entries) {
        io::copy(&mut io::repeat(0).take(entry.offset - end), out)?;
        out.write_all(bytes)?;
        end = entry.offset + entry.length;
    }
    Ok(())
}
