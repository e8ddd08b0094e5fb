//! Elements of accessors, read one by one, with every bound checked before the first read.

use gltf::accessor::{DataType, Dimensions};

use super::Reason;
use super::resources::Resources;

/// Most elements of an accessor that has no buffer view, and so is all zeros but for sparse values: such a
/// claim costs the file nothing.
const MAX_IMPLICIT_ELEMENTS: usize = 1 << 20;

/// A checked accessor.
pub(super) struct Elements<'a> {
    /// How many elements there are.
    pub(super) count: usize,
    base: Option<Strided<'a>>,
    /// Sparse replacements: element index, sorted, and its position in `sparse_values`.
    sparse_indices: Vec<u32>,
    sparse_values: Option<Strided<'a>>,
    component: DataType,
    normalized: bool,
}

/// Elements at regular distances in bytes.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    /// Checks that `count` elements of `size` bytes lie inside the view.
    fn new(
        resources: &'a Resources<'_>,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<Self, Reason> {
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(format!("its elements of {size} bytes overlap at byteStride {stride}"));
        }
        let bytes = resources.view(view)?;
        let end = count
            .checked_sub(1)
            .map_or(Some(0), |last| last.checked_mul(stride).and_then(|start| start.checked_add(size)))
            .and_then(|length| length.checked_add(offset));
        let fits = end.is_some_and(|end| end <= bytes.len());
        if !fits {
            return Err(format!(
                "its {count} elements of {size} bytes do not fit into bufferViews[{}] of {} bytes",
                view.index(),
                bytes.len()
            ));
        }
        Ok(Self { bytes: bytes.get(offset..).unwrap_or_default(), stride, size })
    }

    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

impl<'a> Elements<'a> {
    /// Checks that an accessor has elements of the wanted `dimensions` and lies inside its buffers.
    pub(super) fn new(
        accessor: &gltf::Accessor<'_>,
        dimensions: Dimensions,
        resources: &'a Resources<'_>,
    ) -> Result<Self, Reason> {
        Self::checked(accessor, dimensions, resources)
            .map_err(|reason| format!("accessors[{}]: {reason}", accessor.index()))
    }

    fn checked(
        accessor: &gltf::Accessor<'_>,
        dimensions: Dimensions,
        resources: &'a Resources<'_>,
    ) -> Result<Self, Reason> {
        if accessor.dimensions() != dimensions {
            return Err(format!("{dimensions:?} elements expected, {:?} found", accessor.dimensions()));
        }
        let (count, size) = (accessor.count(), accessor.size());
        let base = accessor
            .view()
            .map(|view| Strided::new(resources, &view, accessor.offset(), count, size))
            .transpose()?;
        let (sparse_indices, sparse_values) = match accessor.sparse() {
            Some(sparse) => sparse_elements(&sparse, size, count, resources)?,
            None => (Vec::new(), None),
        };
        let (component, normalized) = (accessor.data_type(), accessor.normalized());
        Ok(Self { count, base, sparse_indices, sparse_values, component, normalized })
    }

    /// Refuses many elements that cost the file nothing. Whoever stores something for each element asks for this.
    pub(super) fn backed(self, accessor: &gltf::Accessor<'_>) -> Result<Self, Reason> {
        if self.base.is_some() || self.count <= MAX_IMPLICIT_ELEMENTS {
            return Ok(self);
        }
        Err(format!(
            "accessors[{}]: it claims {} elements, but has no data for them",
            accessor.index(),
            self.count
        ))
    }

    /// The components of an element as numbers; integers of a normalized accessor are scaled to [0, 1] or
    /// [−1, 1].
    pub(super) fn vector<const N: usize>(&self, index: usize) -> [f32; N] {
        let Some(bytes) = self.element(index) else { return [0.0; N] };
        let mut components = bytes.chunks_exact(self.component.size());
        std::array::from_fn(|_| components.next().map_or(0.0, |bytes| self.decode(bytes)))
    }

    /// The first component of an element as an index; only unsigned integers are.
    pub(super) fn index(&self, index: usize) -> u32 {
        self.element(index).map_or(0, index_from_bytes)
    }

    fn element(&self, index: usize) -> Option<&'a [u8]> {
        if let (Some(values), Ok(at)) =
            (&self.sparse_values, self.sparse_indices.binary_search(&(index as u32)))
        {
            return Some(values.element(at));
        }
        self.base.as_ref().map(|base| base.element(index))
    }

    fn decode(&self, bytes: &[u8]) -> f32 {
        let scale = |value: f32, largest: f32| {
            if self.normalized { (value / largest).max(-1.0) } else { value }
        };
        match (self.component, bytes) {
            (DataType::I8, &[a]) => scale(f32::from(a as i8), 127.0),
            (DataType::U8, &[a]) => scale(f32::from(a), 255.0),
            (DataType::I16, &[a, b]) => scale(f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (DataType::U16, &[a, b]) => scale(f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (DataType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f32,
            (DataType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => 0.0,
        }
    }
}

/// Little-endian unsigned integer of one, two or four bytes.
fn index_from_bytes(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

type SparseElements<'a> = (Vec<u32>, Option<Strided<'a>>);

fn sparse_elements<'a>(
    sparse: &gltf::accessor::sparse::Sparse<'_>,
    size: usize,
    count: usize,
    resources: &'a Resources<'_>,
) -> Result<SparseElements<'a>, Reason> {
    let (positions, values) = (sparse.indices(), sparse.values());
    let index_size = positions.index_type().size();
    let indices = Strided::new(resources, &positions.view(), positions.offset(), sparse.count(), index_size)?;
    let values = Strided::new(resources, &values.view(), values.offset(), sparse.count(), size)?;
    let indices: Vec<u32> = (0..sparse.count()).map(|i| index_from_bytes(indices.element(i))).collect();
    if !indices.is_sorted_by(|a, b| a < b) {
        return Err("its sparse indices do not increase".into());
    }
    if indices.last().is_some_and(|last| *last as usize >= count) {
        return Err(format!("a sparse index lies beyond its {count} elements"));
    }
    Ok((indices, Some(values)))
}
