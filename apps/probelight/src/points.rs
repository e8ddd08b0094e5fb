//! Tables of points: CSV with a header line, whose columns are known by name.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, ensure};
use probelight_math::glam::Vec3;

/// A table as text; columns that are not understood are kept as they are.
pub(crate) struct PointsTable {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl PointsTable {
    /// A table of `rows`, each with a field for every column.
    pub(crate) fn new(columns: &[&str], rows: Vec<Vec<String>>) -> Self {
        Self { columns: columns.iter().map(|name| (*name).to_owned()).collect(), rows }
    }

    /// Keeps only some of the rows.
    pub(crate) fn retain_rows(&mut self, stays: impl Fn(usize) -> bool) {
        let mut row = 0..;
        self.rows.retain(|_| row.next().is_some_and(&stays));
    }

    /// Reads a table and checks that every row has a field for every column.
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {shown}"))?;
        Self::parse(&text).with_context(|| format!("{shown} is not a usable table of points"))
    }

    fn parse(text: &str) -> anyhow::Result<Self> {
        let fields = |line: &str| line.split(',').map(|field| field.trim().to_owned()).collect::<Vec<_>>();
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let columns = lines.next().map(|(_, line)| fields(line)).context("it is empty")?;
        let mut rows = Vec::new();
        for (number, line) in lines {
            let row = fields(line);
            let (found, wanted) = (row.len(), columns.len());
            ensure!(found == wanted, "line {} has {found} fields, not {wanted}", number + 1);
            rows.push(row);
        }
        Ok(Self { columns, rows })
    }

    fn column(&self, name: &str) -> anyhow::Result<usize> {
        self.columns.iter().position(|c| c == name).with_context(|| format!("it has no column {name}"))
    }

    /// Three columns as finite vectors, such as `position_x`, `position_y`, `position_z`.
    pub(crate) fn vectors(&self, names: [&str; 3]) -> anyhow::Result<Vec<Vec3>> {
        let columns = [self.column(names[0])?, self.column(names[1])?, self.column(names[2])?];
        let number = |row: usize, column: usize| {
            let field = &self.rows[row][column];
            let value = field.parse::<f32>().ok().filter(|value| value.is_finite());
            value.with_context(|| {
                format!("row {}, {}: {field:?} is not a number", row + 1, self.columns[column])
            })
        };
        let vector = |row| {
            let [x, y, z] = columns.map(|column| number(row, column));
            Ok(Vec3::new(x?, y?, z?))
        };
        (0..self.rows.len()).map(vector).collect()
    }

    /// Sets the columns `NAME_r`, `NAME_g`, `NAME_b`, adding those that are missing.
    pub(crate) fn set_colors(&mut self, name: &str, colors: impl Iterator<Item = Vec3>) {
        let places = ["r", "g", "b"].map(|channel| {
            let column = format!("{name}_{channel}");
            self.column(&column).unwrap_or_else(|_| {
                self.columns.push(column);
                self.columns.len() - 1
            })
        });
        for (row, color) in self.rows.iter_mut().zip(colors) {
            row.resize(self.columns.len(), String::new());
            for (place, value) in places.into_iter().zip(color.to_array()) {
                row[place] = value.to_string();
            }
        }
    }

    /// The table as text.
    pub(crate) fn to_csv(&self) -> String {
        let mut text = self.columns.join(",") + "\n";
        for row in &self.rows {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", row.join(","));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const XYZ: [&str; 3] = ["p_x", "p_y", "p_z"];

    #[test]
    fn columns_are_found_by_name_and_others_are_kept() {
        let mut table = PointsTable::parse("note,p_z,p_y,p_x,E_g\na,3,2,1,9\nb,6,5,4,9\n").unwrap();
        assert_eq!(table.vectors(XYZ).unwrap(), [Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0)]);
        table.set_colors("E", [Vec3::new(0.5, 0.25, 0.125), Vec3::ZERO].into_iter());
        assert_eq!(table.to_csv(), "note,p_z,p_y,p_x,E_g,E_r,E_b\na,3,2,1,0.25,0.5,0.125\nb,6,5,4,0,0,0\n");
    }

    #[test]
    fn broken_tables_are_refused_with_the_place() {
        let message = |text: &str| {
            let vectors = PointsTable::parse(text).and_then(|table| table.vectors(XYZ));
            format!("{:#}", vectors.unwrap_err())
        };
        assert!(message("").contains("empty"));
        assert!(message("p_x,p_y\n1,2\n").contains("no column p_z"));
        assert!(message("p_x,p_y,p_z\n1,2\n").contains("line 2 has 2 fields, not 3"));
        assert!(message("p_x,p_y,p_z\n1,2,3\n1,nan,3\n").contains("row 2, p_y"));
    }
}
