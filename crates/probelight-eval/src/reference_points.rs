//! Tables of path-traced irradiance at points, as comma-separated values.
//!
//! The first line names the columns, in any order; columns that are not needed are ignored.
//!
//! ```text
//! position_{x,y,z}  normal_{x,y,z}                          metres, world space; unit
//! E_{delta,area,sky,indirect}_{r,g,b}                       irradiance, W/m²
//! se_{area,sky,indirect}_{r,g,b}                            standard error of the mean
//! kind                                                      0 on a surface, 1 in free space; without it all are on surfaces
//! sampling, triangle_area                                   optional: 0 by area, 1 by triangle; m²
//! ```

use std::path::Path;

use probelight_math::glam::Vec3;

use crate::EvalError;

/// Where a reference point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// On a surface.
    Surface,
    /// In free space, with any normal: what a moving object would receive.
    FreeSpace,
}

/// How points on surfaces were chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Evenly over the area.
    #[default]
    ByArea,
    /// Evenly over the triangles, so that small ones count as much as large ones.
    ByTriangle,
}

/// Irradiance at one point. Irradiances and their standard errors are in W/m², linear Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferencePoint {
    /// World position, metres.
    pub position: Vec3,
    /// Unit normal of the side that receives.
    pub normal: Vec3,
    /// Where the point lies.
    pub kind: PointKind,
    /// How the point was chosen; by area if the table does not say.
    pub sampling: Sampling,
    /// Area of the triangle it lies on, m², if the table says.
    pub triangle_area: Option<f32>,
    /// From point, spot and directional lights, without any bounce.
    pub irradiance_delta: Vec3,
    /// From emissive surfaces, without any bounce.
    pub irradiance_area: Vec3,
    /// From the sky, without any bounce.
    pub irradiance_sky: Vec3,
    /// Everything that bounced at least once.
    pub irradiance_indirect: Vec3,
    /// Standard error of `irradiance_area`.
    pub se_area: Vec3,
    /// Standard error of `irradiance_sky`.
    pub se_sky: Vec3,
    /// Standard error of `irradiance_indirect`.
    pub se_indirect: Vec3,
}

/// A table of reference points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferencePoints {
    /// At least one point, in the order of the file.
    pub points: Vec<ReferencePoint>,
}

impl ReferencePoints {
    /// Reads a table of reference points.
    ///
    /// # Errors
    /// [`EvalError::Io`] if the file cannot be read; [`EvalError::Points`], with the line, if a column is
    /// missing or named twice, a row has too few or too many values, a value is not a finite number, a
    /// normal is not a unit vector, a standard error is negative, or there is no row at all.
    pub fn read(path: &Path) -> Result<Self, EvalError> {
        let text = std::fs::read_to_string(path).map_err(|source| EvalError::Io {
            action: "read",
            path: path.into(),
            source,
        })?;
        parse(&text).map_err(|(line, reason)| EvalError::Points { path: path.into(), line, reason })
    }
}

/// A line, counted from 1, and what is wrong with it.
type LineError = (usize, String);

/// Deviation of a normal's length from 1 that six decimal digits can explain, and no more.
const UNIT_TOLERANCE: f32 = 1e-3;

fn parse(text: &str) -> Result<ReferencePoints, LineError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (at, header) =
        lines.next().ok_or((1, "the file is empty; it should name its columns here".into()))?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let columns = Columns::find(&names).map_err(|reason| (at + 1, reason))?;
    let mut values = Vec::new();
    let mut points = Vec::new();
    for (at, line) in lines {
        let point = parse_row(line, &names, &mut values).and_then(|()| columns.point(&values));
        points.push(point.map_err(|reason| (at + 1, reason))?);
    }
    if points.is_empty() {
        return Err((at + 2, "there are no rows below the column names".into()));
    }
    Ok(ReferencePoints { points })
}

/// Splits a row into one number per column. Values that are not finite pass here: columns that nobody needs
/// may hold them.
fn parse_row(line: &str, names: &[&str], values: &mut Vec<f32>) -> Result<(), String> {
    let count = line.split(',').count();
    if count != names.len() {
        return Err(format!("{count} values for {} columns", names.len()));
    }
    values.clear();
    for (name, text) in names.iter().zip(line.split(',').map(str::trim)) {
        values.push(text.parse().map_err(|_| format!("'{text}' in column {name} is not a number"))?);
    }
    Ok(())
}

/// Three columns that form a vector or colour.
#[derive(Clone, Copy)]
struct VectorColumns {
    name: &'static str,
    at: [usize; 3],
}

impl VectorColumns {
    fn get(&self, row: &[f32]) -> Result<Vec3, String> {
        let value = Vec3::from(self.at.map(|column| row[column]));
        if value.is_finite() { Ok(value) } else { Err(format!("{} is not finite: {value}", self.name)) }
    }

    fn standard_error(&self, row: &[f32]) -> Result<Vec3, String> {
        let value = self.get(row)?;
        let negative = value.cmplt(Vec3::ZERO).any();
        if negative { Err(format!("{} is negative: {value}", self.name)) } else { Ok(value) }
    }
}

/// Where in a row the needed values are.
struct Columns {
    position: VectorColumns,
    normal: VectorColumns,
    delta: VectorColumns,
    area: VectorColumns,
    sky: VectorColumns,
    indirect: VectorColumns,
    se_area: VectorColumns,
    se_sky: VectorColumns,
    se_indirect: VectorColumns,
    kind: Option<usize>,
    sampling: Option<usize>,
    triangle_area: Option<usize>,
}

impl Columns {
    fn find(names: &[&str]) -> Result<Self, String> {
        let find = |wanted: &str| {
            let mut places = (0..names.len()).filter(|column| names[*column] == wanted);
            match (places.next(), places.next()) {
                (Some(column), None) => Ok(column),
                (Some(_), Some(_)) => Err(format!("there are two columns {wanted}")),
                (None, _) => Err(format!("there is no column {wanted}")),
            }
        };
        let find_optional = |wanted| if names.contains(&wanted) { find(wanted).map(Some) } else { Ok(None) };
        let vector = |name, suffixes: [&str; 3]| {
            let [a, b, c] = suffixes.map(|suffix| find(&format!("{name}_{suffix}")));
            Ok::<_, String>(VectorColumns { name, at: [a?, b?, c?] })
        };
        let color = |name| vector(name, ["r", "g", "b"]);
        Ok(Self {
            position: vector("position", ["x", "y", "z"])?,
            normal: vector("normal", ["x", "y", "z"])?,
            delta: color("E_delta")?,
            area: color("E_area")?,
            sky: color("E_sky")?,
            indirect: color("E_indirect")?,
            se_area: color("se_area")?,
            se_sky: color("se_sky")?,
            se_indirect: color("se_indirect")?,
            kind: find_optional("kind")?,
            sampling: find_optional("sampling")?,
            triangle_area: find_optional("triangle_area")?,
        })
    }

    fn point(&self, row: &[f32]) -> Result<ReferencePoint, String> {
        let normal = self.normal.get(row)?;
        if (normal.length() - 1.0).abs() > UNIT_TOLERANCE {
            return Err(format!("the normal {normal} is not a unit vector"));
        }
        let kind = match self.kind.map_or(0.0, |column| row[column]) {
            0.0 => PointKind::Surface,
            1.0 => PointKind::FreeSpace,
            other => return Err(format!("kind is {other}; 0 (surface) and 1 (free space) are known")),
        };
        let sampling = match self.sampling.map_or(0.0, |column| row[column]) {
            0.0 => Sampling::ByArea,
            1.0 => Sampling::ByTriangle,
            other => return Err(format!("sampling is {other}; 0 (by area) and 1 (by triangle) are known")),
        };
        let triangle_area = self.triangle_area.map(|column| row[column]);
        if let Some(area) = triangle_area.filter(|area| !(area.is_finite() && *area >= 0.0)) {
            return Err(format!("triangle_area is {area}, which is no area"));
        }
        Ok(ReferencePoint {
            position: self.position.get(row)?,
            normal: normal.normalize(),
            kind,
            sampling,
            triangle_area,
            irradiance_delta: self.delta.get(row)?,
            irradiance_area: self.area.get(row)?,
            irradiance_sky: self.sky.get(row)?,
            irradiance_indirect: self.indirect.get(row)?,
            se_area: self.se_area.standard_error(row)?,
            se_sky: self.se_sky.standard_error(row)?,
            se_indirect: self.se_indirect.standard_error(row)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "kind,position_x,position_y,position_z,normal_x,normal_y,normal_z,\
        albedo_r,E_delta_r,E_delta_g,E_delta_b,E_area_r,E_area_g,E_area_b,E_sky_r,E_sky_g,E_sky_b,\
        E_indirect_r,E_indirect_g,E_indirect_b,se_area_r,se_area_g,se_area_b,se_sky_r,se_sky_g,se_sky_b,\
        se_indirect_r,se_indirect_g,se_indirect_b";
    const ROW: &str = "1,1,2,3,0,-1,0,nan,4,5,6,7,8,9,10,11,12,13,14,15,.1,.2,.3,.4,.5,.6,.7,.8,.9";

    fn failure(text: &str) -> (usize, String) {
        parse(text).expect_err("a broken table was accepted")
    }

    #[test]
    fn values_are_found_by_their_columns_names() {
        let table = parse(&format!("{HEADER}\r\n{ROW}\r\n\r\n")).unwrap();
        let expected = ReferencePoint {
            position: Vec3::new(1.0, 2.0, 3.0),
            normal: Vec3::NEG_Y,
            kind: PointKind::FreeSpace,
            sampling: Sampling::ByArea,
            triangle_area: None,
            irradiance_delta: Vec3::new(4.0, 5.0, 6.0),
            irradiance_area: Vec3::new(7.0, 8.0, 9.0),
            irradiance_sky: Vec3::new(10.0, 11.0, 12.0),
            irradiance_indirect: Vec3::new(13.0, 14.0, 15.0),
            se_area: Vec3::new(0.1, 0.2, 0.3),
            se_sky: Vec3::new(0.4, 0.5, 0.6),
            se_indirect: Vec3::new(0.7, 0.8, 0.9),
        };
        assert_eq!(table.points, [expected]);
        let reversed = |line: &str| line.split(',').rev().collect::<Vec<_>>().join(",");
        assert_eq!(parse(&format!("{}\n{}", reversed(HEADER), reversed(ROW))).unwrap(), table);
    }

    #[test]
    fn a_bad_header_is_named() {
        assert_eq!(failure(""), (1, "the file is empty; it should name its columns here".into()));
        assert_eq!(failure("a,b\n1,2\n"), (1, "there is no column position_x".into()));
        assert_eq!(failure(&HEADER.replace("normal_x", "n")), (1, "there is no column normal_x".into()));
        let without_kind = parse(&format!("{}\n{ROW}", HEADER.replace("kind", "sort"))).unwrap();
        assert_eq!(without_kind.points[0].kind, PointKind::Surface, "without a column of kinds");
        assert_eq!(failure(&format!("{HEADER},kind\n{ROW},1")), (1, "there are two columns kind".into()));
        assert_eq!(failure(HEADER), (2, "there are no rows below the column names".into()));
    }

    #[test]
    fn a_bad_row_is_named_with_its_line() {
        let third_line = |row: &str| {
            let (line, reason) = failure(&format!("{HEADER}\n{ROW}\n{row}\n"));
            assert_eq!(line, 3);
            reason
        };
        assert_eq!(third_line("1,2"), "2 values for 29 columns");
        assert_eq!(third_line(&format!("{ROW},1")), "30 values for 29 columns");
        assert_eq!(third_line(&ROW.replace(",13,", ",x,")), "'x' in column E_indirect_r is not a number");
        assert_eq!(third_line(&ROW.replace(",13,", ",,")), "'' in column E_indirect_r is not a number");
        assert!(third_line(&ROW.replace(",13,", ",nan,")).starts_with("E_indirect is not finite"));
        assert!(third_line(&ROW.replace(".5", "-.5")).starts_with("se_sky is negative"));
        assert!(third_line(&ROW.replace("-1", "-1.1")).ends_with("is not a unit vector"));
        assert!(third_line(&ROW.replacen('1', "2", 1)).starts_with("kind is 2"));
    }

    #[test]
    fn errors_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        assert!(ReferencePoints::read(&path).unwrap_err().to_string().starts_with("cannot read"));
        std::fs::write(&path, "a\n").unwrap();
        let message = ReferencePoints::read(&path).unwrap_err().to_string();
        assert!(message.ends_with("points.csv, line 1: there is no column position_x"), "{message}");
    }
}
