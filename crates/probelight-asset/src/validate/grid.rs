//! The grid: as many blocks as its size says, vertices one after the other, rows held by receivers of its own.

use probelight_math::glam::Vec3;

use crate::BakedParts;

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
        let mut end = 0;
        for (b, block) in self.grid_blocks.iter().enumerate() {
            ensure!(
                u64::from(block.first_vertex) == end,
                "block {b} of the grid does not start where the last one ends"
            );
            end += u64::from(block.mask().count_ones());
        }
        let vertices = self.grid_vertices.len();
        ensure!(end == vertices as u64, "the grid's blocks need {end} vertices, and there are {vertices}");
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
        self.check_grid_clusters()
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
