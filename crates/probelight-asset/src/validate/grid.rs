//! The grid: as many blocks as its size says, vertices one after the other, rows held by receivers of its own.

use probelight_math::glam::{UVec3, Vec3};

use crate::{BakedParts, GridBlock, MAX_GRID_LEVELS, NONE};

impl BakedParts {
    pub(super) fn check_grid(&self) -> Result<(), String> {
        let grid = &self.grid;
        let usable =
            grid.origin.is_finite() && grid.spacing.is_finite() && grid.spacing.cmpge(Vec3::ZERO).all();
        ensure!(usable, "the grid has an origin or a spacing that is not usable");
        let [x, y, z] = grid.blocks().to_array().map(u64::from);
        let blocks = x.checked_mul(y).and_then(|xy| xy.checked_mul(z));
        ensure!(
            blocks == Some(self.grid_blocks.len() as u64),
            "{} blocks of a grid with {} × {} × {} vertices",
            self.grid_blocks.len(),
            grid.counts.x,
            grid.counts.y,
            grid.counts.z
        );
        let vertices = self.grid_vertices.len();
        ensure!(
            grid.levels <= MAX_GRID_LEVELS,
            "{} levels of a grid, more than {MAX_GRID_LEVELS}",
            grid.levels
        );
        let coarsest = 1 << grid.levels.saturating_sub(1);
        ensure!(
            grid.counts.saturating_sub(UVec3::ONE) % coarsest == UVec3::ZERO,
            "a grid whose coarsest cells do not fit into it"
        );
        for (b, block) in self.grid_blocks.iter().enumerate() {
            let fits =
                block.level < grid.levels.max(1) && block.mask() & !GridBlock::places(block.level) == 0;
            ensure!(fits, "block {b} of the grid has vertices that its level {} does not have", block.level);
        }
        ensure!(
            vertices == 0
                || grid.levels > 0
                    && grid.counts.cmpge(UVec3::splat(2)).all()
                    && grid.spacing.min_element() > 0.0,
            "a grid without cells between its vertices"
        );
        check_blocks(&self.grid_blocks, vertices, "vertices")?;
        let rows = self.settings.grid_basis.rows();
        ensure!(
            vertices.checked_mul(rows) == Some(self.grid_receivers.len()),
            "{} rows of {vertices} vertices of the grid with {rows} each",
            self.grid_receivers.len()
        );
        let own = self.receiver_texels.len()..self.receiver_count();
        for (r, receiver) in self.grid_receivers.iter().enumerate() {
            ensure!(
                own.contains(&(*receiver as usize)),
                "row {r} of the grid is held by receiver {receiver}, which is not the grid's"
            );
        }
        self.check_walls()?;
        self.check_grid_clusters()
    }

    fn check_walls(&self) -> Result<(), String> {
        let (blocks, cell_blocks) =
            (self.grid.first_cell_block(self.grid.levels), self.grid_cell_blocks.len());
        ensure!(
            cell_blocks == 0 || cell_blocks == blocks,
            "{cell_blocks} blocks of cells of a grid with {blocks} of them"
        );
        check_blocks(&self.grid_cell_blocks, self.grid_cells.len(), "cells")?;
        let planes = self.grid_planes.len();
        for (c, cell) in self.grid_cells.iter().enumerate() {
            let mut missing =
                cell.planes.iter().filter(|plane| **plane != NONE && **plane as usize >= planes);
            if let Some(plane) = missing.next() {
                return Err(format!("cell {c} of the grid is divided by plane {plane} of {planes}"));
            }
        }
        ensure!(self.grid_planes.iter().all(|plane| plane.is_finite()), "a plane of the grid is not finite");
        Ok(())
    }

    /// No cluster holds receivers of the lightmap and of the grid.
    fn check_grid_clusters(&self) -> Result<(), String> {
        let first = self.receiver_texels.len() as u64;
        for (c, cluster) in self.clusters.iter().enumerate() {
            let (start, count) = (u64::from(cluster.first_receiver), u64::from(cluster.receiver_count));
            ensure!(
                start >= first || start + count <= first,
                "cluster {c} holds receivers of lightmap and grid"
            );
        }
        Ok(())
    }
}

/// Blocks follow each other without gaps.
fn check_blocks(blocks: &[GridBlock], count: usize, what: &str) -> Result<(), String> {
    let mut end = 0;
    for (b, block) in blocks.iter().enumerate() {
        ensure!(
            u64::from(block.first) == end,
            "block {b} of the grid's {what} does not start where the last one ends"
        );
        end += u64::from(block.mask().count_ones());
    }
    ensure!(end == count as u64, "the grid's blocks need {end} {what}, and there are {count}");
    Ok(())
}
