//! Structs that the host and the shaders share.

#![cfg_attr(not(test), expect(dead_code, reason = "only the test that compares layouts asks for them"))]

/// One field of a struct as the host lays it out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SharedField {
    /// Its name, the same in WGSL.
    pub(super) name: &'static str,
    /// Bytes from the struct's start.
    pub(super) offset: usize,
    /// Its length, bytes.
    pub(super) size: usize,
}

/// A `#[repr(C)]` struct that WGSL declares too. A test compares the two, field by field.
pub(super) trait SharedStruct: bytemuck::Pod {
    /// Name of the struct in WGSL.
    const NAME: &'static str;
    /// All fields in order.
    const FIELDS: &'static [SharedField];
}

/// Declares a struct of plain numbers with its layout as a [`SharedStruct`].
macro_rules! shared_struct {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident {
            $($(#[$field_attribute:meta])* $field_visibility:vis $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        #[repr(C)]
        $visibility struct $name {
            $($(#[$field_attribute])* $field_visibility $field: $type,)*
        }

        impl $crate::gpu::shared_struct::SharedStruct for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [$crate::gpu::shared_struct::SharedField] = &[$($crate::gpu::shared_struct::SharedField {
                name: stringify!($field),
                offset: std::mem::offset_of!($name, $field),
                size: size_of::<$type>(),
            },)*];
        }
    };
}

pub(super) use shared_struct;
