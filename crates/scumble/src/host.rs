//! What the host lends to passes: a scene, an audio clock, anything with a name and a type.

use std::any::{Any, TypeId, type_name};

/// Values of the host that passes ask for by type; graphs and messages speak of them by name.
///
/// ```
/// struct Scene { triangles: u32 }
/// let mut host = scumble::Host::new();
/// host.insert("Scene", Scene { triangles: 12 });
/// assert!(host.has("Scene"));
/// assert_eq!(host.get::<Scene>().map(|scene| scene.triangles), Some(12));
/// ```
#[derive(Default)]
pub struct Host {
    entries: Vec<Entry>,
}

struct Entry {
    name: &'static str,
    type_name: &'static str,
    value: Box<dyn Any + Send>,
}

impl Host {
    /// A host that lends nothing.
    pub fn new() -> Host {
        Host::default()
    }

    /// Lends `value` under `name`; a former value of the same name or type is replaced.
    pub fn insert<T: Any + Send>(&mut self, name: &'static str, value: T) {
        self.entries
            .retain(|e| e.name != name && e.value.as_ref().type_id() != TypeId::of::<T>());
        self.entries.push(Entry {
            name,
            type_name: type_name::<T>(),
            value: Box::new(value),
        });
    }

    /// The value of type `T`.
    pub fn get<T: 'static>(&self) -> Option<&T> {
        self.entries.iter().find_map(|e| e.value.downcast_ref())
    }

    /// The value of type `T`, to change between frames.
    pub fn get_mut<T: 'static>(&mut self) -> Option<&mut T> {
        self.entries.iter_mut().find_map(|e| e.value.downcast_mut())
    }

    /// Whether something is lent under `name`.
    pub fn has(&self, name: &str) -> bool {
        self.entries.iter().any(|e| e.name == name)
    }

    /// Names of what is lent, in the order of insertion.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.entries.iter().map(|e| e.name)
    }
}

impl std::fmt::Debug for Host {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_map()
            .entries(self.entries.iter().map(|e| (e.name, e.type_name)))
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_per_name_and_per_type() {
        let mut host = Host::new();
        host.insert("A", 1u32);
        host.insert("B", 2u32);
        assert_eq!(host.get::<u32>(), Some(&2));
        assert!(!host.has("A"), "a second u32 would make `get` ambiguous");
        host.insert("B", 3.0f32);
        assert!(host.get::<u32>().is_none());
        assert_eq!(host.names().collect::<Vec<_>>(), ["B"]);
    }
}
