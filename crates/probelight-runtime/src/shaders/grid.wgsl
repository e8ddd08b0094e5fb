// Irradiance in free space, between the vertices of the grid ([SED] §4). The twin of irradiance_grid.rs and
// grid_light.rs.

// The basis of vertices; without a grid they have no rows.
const GRID_SH2 = 0u;
const GRID_AXES = 1u;
const GRID_COSINES = 2u;

const MAX_GRID_ROWS = 26u;

// What stands for nothing at a place, and for no plane.
const NONE = 0xFFFFFFFFu;

// Places along each edge of a block.
const BLOCK_EDGE = 4u;

// Most levels of a grid, and the corners of their cells.
const MAX_GRID_LEVELS = 3u;
const MAX_GRID_CORNERS = 24u;

// Where so little weight is left, the corners that light a place count the same.
const SMALLEST_WEIGHT = 1e-4;

struct Grid {
    // World position of the first place, metres.
    origin: vec3f,
    // Rows of each vertex.
    rows: u32,
    // World position of the last place, metres.
    last: vec3f,
    // One of the constants above.
    kind: u32,
    // Distance between neighbours, metres.
    spacing: vec3f,
    // How far off its surface a point is looked at once more, metres.
    off_surface: f32,
    // Places along each axis.
    counts: vec3u,
    // Number of the spheres in place of objects.
    sphere_count: u32,
    // Index of the first block of each level's cells (xyz), and the number of levels.
    cell_blocks: vec4u,
    // Of GRID_COSINES: how the cosine of a row's direction with the normal counts, a + b t + c t².
    polynomial: vec4f,
    // Unit directions of the rows (xyz); spherical harmonics are read without. Of GRID_COSINES, the row's share (w).
    axes: array<vec4f, MAX_GRID_ROWS>,
}

// Which of 4³ places have something: bit x + 4 y + 16 z of two halves.
struct GridBlock {
    present: vec2u,
    // Number of the first of it.
    first: u32,
    // Vertices lie at multiples of 2 to the power of it.
    level: u32,
    // The vertex nearest to the first place; nothing for blocks of cells.
    nearest: u32,
}

struct GridCell {
    planes: vec4u,
    // Four parts in each number.
    corners: vec4u,
}

@group(3) @binding(0) var<uniform> grid: Grid;
// Blocks of vertices, x fastest, then those of each level's cells.
@group(3) @binding(1) var<storage, read> grid_blocks: array<GridBlock>;
@group(3) @binding(2) var<storage, read> grid_cells: array<GridCell>;
@group(3) @binding(3) var<storage, read> grid_planes: array<vec4f>;
// The receivers that hold the rows of each vertex.
@group(3) @binding(4) var<storage, read> grid_receivers: array<u32>;
// Irradiance of all receivers, W/m²: red, green and blue of one after the other.
@group(3) @binding(5) var<storage, read> receiver_irradiance: array<f32>;

// Corners of a cell: vertices and their weights, which sum to one or are all zero.
struct CellCorners {
    vertices: array<u32, 8>,
    weights: array<f32, 8>,
    // Trilinear share of the corners whose blocks are as fine as the cell.
    covered: f32,
    is_lit: bool,
}

// Light around a place. Nine functions of spherical harmonics are kept; other bases are read from their vertices each time,
// as shaders have no fast arrays of their own.
struct GridLight {
    band_0: vec3f,
    band_1: mat3x3f,
    band_2: array<vec3f, 5>,
    // What these leave out: by a lamp in a direction (unit), of so much flux (W/m²).
    beyond_direction: vec3f,
    beyond_flux: vec3f,
    vertices: array<u32, MAX_GRID_CORNERS>,
    weights: array<f32, MAX_GRID_CORNERS>,
    // How many of these there are, and the sum of their weights.
    count: u32,
    total: f32,
}

// Light at a point of a surface that faces along `normal` (unit).
fn light_in_air(position: vec3f, normal: vec3f) -> GridLight {
    var light: GridLight;
    if grid.rows == 0u {
        return light;
    }
    // Where nothing lights the point, once more off its surface.
    for (var attempt = 0u; attempt < 2u && light.total == 0.0; attempt++) {
        add_light_around(&light, position + f32(attempt) * grid.off_surface * normal);
    }
    if light.total == 0.0 {
        add_nearest_if_outside(&light, position);
    }
    if light.total > 0.0 {
        let scale = 1.0 / light.total;
        light.band_0 *= scale;
        light.band_1 *= scale;
        for (var i = 0u; i < 5u; i++) {
            light.band_2[i] *= scale;
        }
    }
    if grid.kind == GRID_SH2 {
        find_beyond_bands(&light);
    }
    return light;
}

// What three bands leave out of the irradiance by a lamp in light that is even: bands 1 and 2 tell the lamp, which has a
// share of its flux in band 4.
fn find_beyond_bands(light: ptr<function, GridLight>) {
    let x = 2.0 * 0.4886025 * (*light).band_1[2];
    let y = 2.0 * 0.4886025 * (*light).band_1[0];
    let z = 2.0 * 0.4886025 * (*light).band_1[1];
    let vector = vec3f(grid_luminance(x), grid_luminance(y), grid_luminance(z));
    let length = length(vector);
    let direction = select(vec3f(0.0), vector / max(length, 1e-30), length > 0.0);
    let along = max(x * direction.x + y * direction.y + z * direction.z, vec3f(0.0));
    let second = grid_luminance(second_band(light, direction));
    let cosine = clamp(3.2 * second / max(grid_luminance(along), 1e-30), 0.0, SMALLEST_LAMP);
    let flux = min(2.0 * along / (1.0 + cosine), 4.0 * 0.2820948 * (*light).band_0);
    let square = cosine * cosine;
    let third = 0.5 * cosine * (5.0 * square - 3.0);
    let fifth = 0.125 * cosine * ((63.0 * square - 70.0) * square + 15.0);
    (*light).beyond_direction = direction;
    (*light).beyond_flux = flux * (third - fifth) / (9.0 * (1.0 - cosine));
}

// The corners of the cells that a position lies in, as far as they light it. Where a cell has corners in coarser blocks,
// their share comes from the cell of the next level.
fn add_light_around(light: ptr<function, GridLight>, position: vec3f) {
    var rest = 1.0;
    for (var level = 0u; level < grid.cell_blocks.w; level++) {
        var corners = corners_around(level, position);
        // Nothing coarser knows the walls where all corners are there.
        let is_whole = corners.covered > 1.0 - SMALLEST_WEIGHT;
        let share = select(rest * corners.covered, rest, is_whole);
        if corners.is_lit {
            add_corners(light, &corners, share);
            rest -= share;
        }
        if is_whole {
            break;
        }
    }
}

fn add_corners(light: ptr<function, GridLight>, corners: ptr<function, CellCorners>, share: f32) {
    for (var i = 0u; i < 8u; i++) {
        let weight = share * (*corners).weights[i];
        if weight <= 0.0 {
            continue;
        }
        let vertex = (*corners).vertices[i];
        (*light).total += weight;
        if grid.kind == GRID_SH2 {
            let first = 9u * vertex;
            (*light).band_0 += weight * grid_value(first);
            (*light).band_1[0] += weight * grid_value(first + 1u);
            (*light).band_1[1] += weight * grid_value(first + 2u);
            (*light).band_1[2] += weight * grid_value(first + 3u);
            (*light).band_2[0] += weight * grid_value(first + 4u);
            (*light).band_2[1] += weight * grid_value(first + 5u);
            (*light).band_2[2] += weight * grid_value(first + 6u);
            (*light).band_2[3] += weight * grid_value(first + 7u);
            (*light).band_2[4] += weight * grid_value(first + 8u);
        } else {
            (*light).vertices[(*light).count] = vertex;
            (*light).weights[(*light).count] = weight;
            (*light).count++;
        }
    }
}

// The value of a row of a vertex, W/m².
fn grid_value(row: u32) -> vec3f {
    let at = 3u * grid_receivers[row];
    return vec3f(receiver_irradiance[at], receiver_irradiance[at + 1u], receiver_irradiance[at + 2u]);
}

// Irradiance of a surface there that faces along `normal` (unit), W/m².
fn irradiance_from(light: ptr<function, GridLight>, normal: vec3f) -> vec3f {
    if grid.kind != GRID_SH2 {
        return linear_irradiance(light, normal);
    }
    let cosine = dot((*light).beyond_direction, normal);
    let bands = 0.25 + 0.5 * cosine + (5.0 / 32.0) * (3.0 * cosine * cosine - 1.0);
    let beyond = (*light).beyond_flux * (max(cosine, 0.0) - bands);
    return max(harmonics_from(light, normal) + beyond, vec3f(0.0));
}

// The same as what is stored has it.
fn linear_irradiance(light: ptr<function, GridLight>, normal: vec3f) -> vec3f {
    if grid.kind == GRID_SH2 {
        return max(harmonics_from(light, normal), vec3f(0.0));
    }
    var sum = vec3f(0.0);
    var weights = 0.0;
    for (var row = 0u; row < grid.rows; row++) {
        let weight = read_weight(row, normal);
        weights += weight;
        for (var i = 0u; i < (*light).count; i++) {
            let share = weight * (*light).weights[i] / (*light).total;
            sum += share * grid_value((*light).vertices[i] * grid.rows + row);
        }
    }
    return max(sum, vec3f(0.0)) / select(1.0, weights, grid.kind == GRID_AXES && weights > 0.0);
}

fn grid_luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

// A round light source far away: direction to it, cosine of its half opening angle, integral of its radiance.
struct Lamp {
    direction: vec3f,
    cosine: f32,
    flux: vec3f,
}

// Largest cosine of a lamp's half opening angle.
const SMALLEST_LAMP = 0.97;

// How often what is even and what is the lamp are told apart, each by the other.
const LAMP_PASSES = 6u;

// The light that a surface which faces along `normal` (unit) sees, as a lamp in light that is even.
fn lamp_of(light: ptr<function, GridLight>, normal: vec3f) -> Lamp {
    var vectors: array<vec3f, 3>;
    var all = vec3f(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        let unit = vec3f(vec3u(axis) == vec3u(0u, 1u, 2u));
        let before = linear_irradiance(light, unit);
        let after = linear_irradiance(light, -unit);
        vectors[axis] = before - after;
        all += (before + after) / 1.5;
    }
    let behind = linear_irradiance(light, -normal);
    var even = max(0.5 * all - behind, vec3f(0.0));
    var lamp = Lamp(normal, 0.0, vec3f(0.0));
    for (var pass_number = 0u; pass_number < LAMP_PASSES; pass_number++) {
        let x = vectors[0] + (behind - even) * normal.x;
        let y = vectors[1] + (behind - even) * normal.y;
        let z = vectors[2] + (behind - even) * normal.z;
        let vector = vec3f(grid_luminance(x), grid_luminance(y), grid_luminance(z));
        let length = length(vector);
        let direction = select(normal, vector / max(length, 1e-30), length > 0.0);
        let flux = max(x * direction.x + y * direction.y + z * direction.z, vec3f(0.0));
        let across = linear_irradiance(light, direction) + linear_irradiance(light, -direction) - 0.5 * all;
        let cosine = clamp(1.6 * grid_luminance(across) / max(grid_luminance(flux), 1e-30), 0.0, SMALLEST_LAMP);
        lamp = Lamp(direction, cosine, 2.0 * flux / (1.0 + cosine));
        even = max(0.5 * (all - lamp.flux) - behind, vec3f(0.0));
    }
    return lamp;
}

// How much a row counts for a surface with a unit normal; those of GRID_AXES still have to be divided by their sum.
fn read_weight(row: u32, n: vec3f) -> f32 {
    let axis = grid.axes[row];
    let cosine = dot(axis.xyz, n);
    let read = axis.w * (grid.polynomial.x + cosine * (grid.polynomial.y + cosine * grid.polynomial.z));
    return select(max(cosine, 0.0), read, grid.kind == GRID_COSINES);
}

// The sum of spherical harmonics of bands 0 to 2, each times its row.
fn harmonics_from(light: ptr<function, GridLight>, n: vec3f) -> vec3f {
    let sum = 0.2820948 * (*light).band_0 + 0.4886025 * ((*light).band_1 * n.yzx);
    return sum + second_band(light, n);
}

fn second_band(light: ptr<function, GridLight>, n: vec3f) -> vec3f {
    var sum = 1.0925484 * n.x * n.y * (*light).band_2[0];
    sum += 1.0925484 * n.y * n.z * (*light).band_2[1];
    sum += 0.3153916 * (3.0 * n.z * n.z - 1.0) * (*light).band_2[2];
    sum += 1.0925484 * n.x * n.z * (*light).band_2[3];
    return sum + 0.5462742 * (n.x * n.x - n.y * n.y) * (*light).band_2[4];
}

fn corner_at(i: u32) -> vec3u {
    return vec3u(i & 1u, (i >> 1u) & 1u, i >> 2u);
}

// Places along each axis of a level.
fn places_along(level: u32) -> vec3u {
    return (grid.counts - 1u) / (1u << level) + 1u;
}

// Blocks along each axis of a level's places.
fn blocks_along(level: u32) -> vec3u {
    return (places_along(level) + BLOCK_EDGE - 1u) / BLOCK_EDGE;
}

// Index of the block that a place of a level lies in, from the level's first one on.
fn block_of(level: u32, place: vec3u) -> u32 {
    let block = place / BLOCK_EDGE;
    let along = blocks_along(level);
    return block.x + along.x * (block.y + along.y * block.z);
}

// The number of what is at a place of a block, or NONE.
fn number_in(index: u32, place: vec3u) -> u32 {
    let within = place % BLOCK_EDGE;
    let bit = within.x + BLOCK_EDGE * (within.y + BLOCK_EDGE * within.z);
    let present = grid_blocks[index].present;
    let own = 1u << (bit & 31u);
    let half = select(present.x, present.y, bit > 31u);
    let before = countOneBits(half & (own - 1u)) + select(0u, countOneBits(present.x), bit > 31u);
    return select(NONE, grid_blocks[index].first + before, (half & own) != 0u);
}

// Between the places of a level: the cell that a position lies in or is nearest to, and where in it, from 0 to 1.
struct CellPlace {
    position: vec3f,
    cell: vec3u,
    within: vec3f,
}

fn cell_place(level: u32, position: vec3f) -> CellPlace {
    return place_between(places_along(level), grid.spacing * f32(1u << level), position);
}

fn place_between(counts: vec3u, spacing: vec3f, position: vec3f) -> CellPlace {
    let limited = min(max(position, grid.origin), grid.origin + vec3f(counts - 1u) * spacing);
    let at = min((limited - grid.origin) / spacing, vec3f(counts - 1u));
    let cell = max(min(floor(at), vec3f(counts) - 2.0), vec3f(0.0));
    return CellPlace(limited, vec3u(cell), at - cell);
}

fn trilinear_share(place: CellPlace, corner: vec3u) -> f32 {
    let shares = select(1.0 - place.within, place.within, corner == vec3u(1u));
    return shares.x * shares.y * shares.z;
}

fn corners_around(level: u32, position: vec3f) -> CellCorners {
    let place = cell_place(level, position);
    var sight = corners_in_sight(level, place);
    var corners: CellCorners;
    var total = 0.0;
    var seen = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let at = (place.cell + corner_at(i)) << vec3u(level);
        let share = trilinear_share(place, corner_at(i));
        let block = block_of(0u, at);
        let is_covered = grid_blocks[block].level <= level;
        let vertex = select(NONE, number_in(block, at), is_covered);
        let own = select(sight[i / 4u][i % 4u], 0.0, vertex == NONE);
        sight[i / 4u][i % 4u] = own;
        corners.vertices[i] = vertex;
        corners.weights[i] = share * own;
        corners.covered += select(0.0, share, is_covered);
        total += share * own;
        seen += own;
    }
    corners.is_lit = seen > 0.0;
    for (var i = 0u; i < 8u; i++) {
        if total > SMALLEST_WEIGHT {
            corners.weights[i] /= total;
        } else {
            corners.weights[i] = sight[i / 4u][i % 4u] / max(seen, 1e-30);
        }
    }
    return corners;
}

// How far walls let each corner light a place, from 0 to 1: its own cell's sharply, those of the next cells fading in over
// half of it. Corners 0 to 3, then 4 to 7.
fn corners_in_sight(level: u32, place: CellPlace) -> array<vec4f, 2> {
    let is_lower = place.within < vec3f(0.5);
    let nearness = abs(2.0 * (place.within - 0.5));
    var sight = array<vec4f, 2>(vec4f(1.0), vec4f(1.0));
    for (var step = 0u; step < 8u; step++) {
        let stepped = corner_at(step);
        let way = select(vec3i(stepped), -vec3i(stepped), is_lower);
        let low = vec3i(place.cell) + way;
        if any(low < vec3i(0)) || any(low >= vec3i(places_along(level))) {
            continue;
        }
        let number = number_in(grid.cell_blocks[level] + block_of(level, vec3u(low)), vec3u(low));
        if number == NONE {
            continue;
        }
        let shares = select(vec3f(1.0), nearness, stepped == vec3u(1u));
        let share = shares.x * shares.y * shares.z;
        let blocked = corners_from_next(~corners_lighting(number, place.position), way);
        sight[0] *= 1.0 - share * vec4f((vec4u(blocked) >> vec4u(0u, 1u, 2u, 3u)) & vec4u(1u));
        sight[1] *= 1.0 - share * vec4f((vec4u(blocked) >> vec4u(4u, 5u, 6u, 7u)) & vec4u(1u));
    }
    return sight;
}

// The corners of a cell, a bit each, that are those of a cell `way` next to it; of those, the bits that are set there.
fn corners_from_next(next: u32, way: vec3i) -> u32 {
    var bits = next & 0xFFu;
    bits = select(bits, (bits & 0x55u) << 1u, way.x > 0);
    bits = select(bits, (bits & 0xAAu) >> 1u, way.x < 0);
    bits = select(bits, (bits & 0x33u) << 2u, way.y > 0);
    bits = select(bits, (bits & 0xCCu) >> 2u, way.y < 0);
    bits = select(bits, (bits & 0x0Fu) << 4u, way.z > 0);
    return select(bits, (bits & 0xF0u) >> 4u, way.z < 0);
}

// The corners of a cell that light the part of it that a position lies in, a bit each.
fn corners_lighting(number: u32, position: vec3f) -> u32 {
    let cell = grid_cells[number];
    var part = 0u;
    for (var i = 0u; i < 4u; i++) {
        let plane = cell.planes[i];
        if plane == NONE {
            break;
        }
        part |= select(0u, 1u << i, dot(grid_planes[plane], vec4f(position, 1.0)) > 0.0);
    }
    return (cell.corners[part >> 2u] >> (8u * (part & 3u))) & 0xFFu;
}

// Outside the grid, and where cells have no vertices, the nearest ones to the first places of the blocks around.
fn add_nearest_if_outside(light: ptr<function, GridLight>, position: vec3f) {
    var is_empty = true;
    for (var level = 0u; level < grid.cell_blocks.w; level++) {
        let cell = cell_place(level, position).cell;
        for (var i = 0u; i < 8u; i++) {
            let at = (cell + corner_at(i)) << vec3u(level);
            let block = block_of(0u, at);
            is_empty = is_empty && (grid_blocks[block].level > level || number_in(block, at) == NONE);
        }
    }
    if !is_empty && all(cell_place(0u, position).position == position) {
        return;
    }
    let place = place_between(blocks_along(0u), grid.spacing * f32(BLOCK_EDGE), position);
    var corners: CellCorners;
    for (var i = 0u; i < 8u; i++) {
        let block = min(place.cell + corner_at(i), blocks_along(0u) - 1u);
        corners.vertices[i] = grid_blocks[block_of(0u, block * BLOCK_EDGE)].nearest;
        corners.weights[i] = trilinear_share(place, corner_at(i));
    }
    add_corners(light, &corners, 1.0);
}
