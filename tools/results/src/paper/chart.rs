//! Charts as SVG: two panels side by side.

use std::path::Path;

use anyhow::anyhow;
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::documents::write_whole;

/// Points that belong together.
pub(crate) struct Series {
    name: String,
    points: Vec<(f64, f64)>,
    is_dotted: bool,
}

impl Series {
    /// Joined by lines.
    pub(crate) fn new(name: &str, mut points: Vec<(f64, f64)>) -> Self {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { name: name.into(), points, is_dotted: false }
    }

    /// The same with open marks, no lines and the colour of the series before: what is less certain.
    pub(crate) fn dotted(self) -> Self {
        Self { is_dotted: true, ..self }
    }
}

/// One chart.
pub(crate) struct Panel<'a> {
    /// What the axes show.
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
    pub(crate) series: Vec<Series>,
    /// Where there is room for the names.
    pub(crate) legend: SeriesLabelPosition,
}

/// Colours that are told apart with any kind of sight (Okabe and Ito 2008).
const COLORS: [RGBColor; 5] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(204, 121, 167), BLACK];

/// Width and height of all panels together.
const SIZE: (u32, u32) = (960, 360);

const FONT: &str = "sans-serif";

/// Writes panels side by side.
pub(crate) fn draw(panels: &[Panel<'_>], path: &Path) -> anyhow::Result<()> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let areas = area.split_evenly((1, panels.len()));
        area.fill(&WHITE)
            .map_err(anyhow::Error::from)
            .and_then(|()| panels.iter().zip(&areas).try_for_each(|(panel, area)| draw_panel(panel, area)))
            .and_then(|()| Ok(area.present()?))
            .map_err(|error| anyhow!("cannot draw {}: {error}", path.display()))?;
    }
    write_whole(path, text.as_bytes())
}

fn draw_panel(panel: &Panel<'_>, area: &DrawingArea<SVGBackend<'_>, Shift>) -> anyhow::Result<()> {
    let points = || panel.series.iter().flat_map(|series| series.points.iter().copied());
    let x = range(points().map(|(x, _)| x));
    let y = range(points().map(|(_, y)| y).chain([0.0]));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(38)
        .y_label_area_size(52)
        .build_cartesian_2d(x, 0.0..y.end)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc(panel.x)
        .y_desc(panel.y)
        .x_labels(6)
        .x_label_formatter(&|value| label(*value))
        .y_label_formatter(&|value| label(*value))
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 14))
        .draw()?;
    let mut colors = COLORS.iter().cycle();
    let mut color = &BLACK;
    for series in &panel.series {
        // Open marks belong to the series before.
        if !series.is_dotted {
            color = colors.next().unwrap_or(&BLACK);
        }
        let style = ShapeStyle { color: color.to_rgba(), filled: !series.is_dotted, stroke_width: 2 };
        if !series.is_dotted {
            chart.draw_series(LineSeries::new(series.points.iter().copied(), style))?;
        }
        let marks = series.points.iter().map(|point| Circle::new(*point, 4, style));
        chart.draw_series(marks)?.label(&series.name).legend(move |(x, y)| Circle::new((x + 8, y), 4, style));
    }
    chart
        .configure_series_labels()
        .position(panel.legend.clone())
        .background_style(WHITE.mix(0.8))
        .label_font((FONT, 13))
        .draw()?;
    Ok(())
}

/// From the least to the largest, with a little room on both sides.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (least, largest) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
    if least > largest {
        return 0.0..1.0;
    }
    let room = 0.06 * (largest - least).max(1e-3 * largest.abs()).max(f64::MIN_POSITIVE);
    least - room..largest + room
}

/// A number beside an axis.
fn label(value: f64) -> String {
    match value.abs() {
        size if size >= 1000.0 => format!("{:.0}k", value / 1000.0),
        size if size >= 10.0 || size == 0.0 => format!("{value:.0}"),
        size if size >= 1.5 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_all_values_with_room() {
        let range = range([2.0, 1.0, 3.0].into_iter());
        assert!(range.start < 1.0 && range.end > 3.0 && range.end - range.start < 2.5);
        assert_eq!(super::range(std::iter::empty()), 0.0..1.0);
        let single = super::range(std::iter::once(5.0));
        assert!(single.start < 5.0 && single.end > 5.0);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.0, 0.95, 4.34, 20.0, 400_000.0].map(label), ["0", "0.95", "4.3", "20", "400k"]);
    }

    #[test]
    fn charts_name_their_series_and_axes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("chart.svg");
        let series =
            vec![Series::new("ours", vec![(1.0, 2.0), (0.9, 3.0)]), Series::new("none", vec![]).dotted()];
        draw(&[Panel { x: "across", y: "up", series, legend: SeriesLabelPosition::UpperLeft }], &path)
            .unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(["ours", "across", "up", "<svg"].iter().all(|word| text.contains(word)), "{text}");
    }
}
