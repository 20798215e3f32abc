//! One number per pixel, and filtering it in rows and columns.

use rayon::prelude::*;

/// A plane of f64, rows from the top.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    pub width: usize,
    pub data: Vec<f64>,
}

impl Plane {
    /// Each row filtered by a kernel of odd length; beyond the border the border's value goes on.
    pub fn filter_rows(&self, kernel: &[f64]) -> Plane {
        let radius = kernel.len() / 2;
        let mut data = vec![0.0; self.data.len()];
        let rows = data
            .par_chunks_mut(self.width)
            .zip(self.data.par_chunks(self.width));
        rows.for_each_init(Vec::new, |padded, (out, row)| {
            padded.clear();
            padded.extend(std::iter::repeat_n(row[0], radius));
            padded.extend_from_slice(row);
            padded.extend(std::iter::repeat_n(row[row.len() - 1], radius));
            for (k, &weight) in kernel.iter().enumerate() {
                add_scaled(out, &padded[k..], weight);
            }
        });
        Plane { data, ..*self }
    }

    /// Each column filtered by a kernel of odd length; beyond the border the border's value goes on.
    pub fn filter_columns(&self, kernel: &[f64]) -> Plane {
        let radius = kernel.len() / 2;
        let last = self.data.len() / self.width - 1;
        let mut data = vec![0.0; self.data.len()];
        let rows = data.par_chunks_mut(self.width).enumerate();
        rows.for_each(|(y, out)| {
            for (k, &weight) in kernel.iter().enumerate() {
                let from = (y + k).saturating_sub(radius).min(last);
                add_scaled(out, &self.data[from * self.width..], weight);
            }
        });
        Plane { data, ..*self }
    }
}

/// out += weight * row, which the compiler turns into vector code.
pub(crate) fn add_scaled(out: &mut [f64], row: &[f64], weight: f64) {
    for (o, v) in out.iter_mut().zip(row) {
        *o += weight * v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_go_on() {
        let plane = Plane {
            width: 3,
            data: vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0],
        };
        let kernel = [0.0, 0.0, 0.0, 1.0, 10.0];
        // Taps at +1 and +2, ten times the latter.
        assert_eq!(
            plane.filter_rows(&kernel).data,
            [42.0, 44.0, 44.0, 336.0, 352.0, 352.0]
        );
        assert_eq!(
            plane.filter_columns(&kernel).data,
            [88.0, 176.0, 352.0, 88.0, 176.0, 352.0]
        );
    }
}
