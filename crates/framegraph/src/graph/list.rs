//! Lists that a frame writes over what the last frame wrote.

use std::ops::{Deref, DerefMut};

/// A list that still knows what it held before it was begun anew.
pub(crate) struct List<T> {
    items: Vec<T>,
    len: usize,
    /// How long it was before.
    was: usize,
}

impl<T> List<T> {
    /// Empties it; what it held is old from now on.
    pub fn begin(&mut self) {
        (self.was, self.len) = (self.len, 0);
    }

    /// Takes all that it holds as old, and as taken again.
    pub fn repeat(&mut self) {
        self.was = self.len;
    }

    /// What stood before where the next item comes.
    #[inline(always)]
    pub fn old(&mut self) -> Option<&mut T> {
        match self.len < self.was {
            true => self.items.get_mut(self.len),
            false => None,
        }
    }

    /// Takes the old item as the next one.
    #[inline(always)]
    pub fn again(&mut self) {
        self.len = (self.len + 1).min(self.items.len());
    }

    /// Whether it has as many items as before.
    pub fn is_as_long(&self) -> bool {
        self.len == self.was
    }

    #[inline(always)]
    pub fn push(&mut self, item: T) {
        match self.items.get_mut(self.len) {
            Some(old) => *old = item,
            None => self.items.push(item),
        }
        self.len += 1;
    }
}

impl<T> Default for List<T> {
    fn default() -> Self {
        List {
            items: Vec::new(),
            len: 0,
            was: 0,
        }
    }
}

impl<'a, T> IntoIterator for &'a List<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T> Deref for List<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.items[..self.len]
    }
}

impl<T> DerefMut for List<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.items[..self.len]
    }
}
