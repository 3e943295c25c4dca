//! The methods `with_...` of option structs.

/// Writes methods that set one field each and return the struct, so that options are one
/// expression: `Grasp::default().with_starts(16)`. For an `Option`, the parameter is written as
/// `impl Into<Option<T>>`, so that both a value and `None` can be given.
macro_rules! setters {
    ($options:ty { $($(#[$doc:meta])* fn $method:ident($field:ident: $value:ty);)* }) => {
        impl $options {
            $(
                $(#[$doc])*
                #[must_use]
                pub fn $method(mut self, $field: $value) -> Self {
                    self.$field = $field.into();
                    self
                }
            )*
        }
    };
}

pub(crate) use setters;
