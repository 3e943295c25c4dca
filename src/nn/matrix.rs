//! Products of row-major matrices, and the memory for their results.

use matrixmultiply::sgemm;

/// A matrix in a slice: element (i, j) is at `i * stride + j`.
#[derive(Clone, Copy)]
pub(super) struct MatrixView<'a> {
    data: &'a [f32],
    rows: usize,
    columns: usize,
    stride: usize,
}

impl<'a> MatrixView<'a> {
    /// `rows` x `columns`, one row after the other.
    pub(super) fn new(data: &'a [f32], rows: usize, columns: usize) -> Self {
        Self::strided(data, rows, columns, columns)
    }

    /// `rows` x `columns`, the beginnings of rows that are `stride` long.
    pub(super) fn strided(data: &'a [f32], rows: usize, columns: usize, stride: usize) -> Self {
        assert!(columns <= stride && span(rows, columns, stride) <= data.len());
        Self {
            data,
            rows,
            columns,
            stride,
        }
    }
}

/// The number of elements from the first to the last of a matrix.
fn span(rows: usize, columns: usize, stride: usize) -> usize {
    if rows == 0 || columns == 0 {
        0
    } else {
        (rows - 1) * stride + columns
    }
}

/// `c = a b + beta c`; `c` is a.rows x b.columns, dense.
pub(super) fn multiply(a: MatrixView, b: MatrixView, beta: f32, c: &mut [f32]) {
    assert_eq!(a.columns, b.rows);
    product((a, false), (b, false), beta, c);
}

/// `c = a' b + beta c`; `c` is a.columns x b.columns, dense.
pub(super) fn multiply_tn(a: MatrixView, b: MatrixView, beta: f32, c: &mut [f32]) {
    assert_eq!(a.rows, b.rows);
    product((a, true), (b, false), beta, c);
}

/// `c = a b' + beta c`; `c` is a.rows x b.rows, dense.
pub(super) fn multiply_nt(a: MatrixView, b: MatrixView, beta: f32, c: &mut [f32]) {
    assert_eq!(a.columns, b.columns);
    product((a, false), (b, true), beta, c);
}

/// Each operand with a flag that says whether it is transposed; the callers have checked that
/// the inner dimensions agree.
fn product((a, ta): (MatrixView, bool), (b, tb): (MatrixView, bool), beta: f32, c: &mut [f32]) {
    let (m, k) = if ta {
        (a.columns, a.rows)
    } else {
        (a.rows, a.columns)
    };
    let n = if tb { b.rows } else { b.columns };
    assert!(m * n <= c.len());
    let strides = |view: MatrixView, transposed: bool| {
        // A slice is at most isize::MAX bytes long, so its strides fit.
        let stride = view.stride as isize;
        if transposed { (1, stride) } else { (stride, 1) }
    };
    let (ra, ca) = strides(a, ta);
    let (rb, cb) = strides(b, tb);
    // SAFETY: `MatrixView::strided` checked that every element of `a` and `b` lies in its
    // slice, the line above that `c` has room for m x n dense elements, and `c` is
    // borrowed mutably, so it overlaps neither.
    #[allow(unsafe_code)]
    unsafe {
        sgemm(
            m,
            k,
            n,
            1.0,
            a.data.as_ptr(),
            ra,
            ca,
            b.data.as_ptr(),
            rb,
            cb,
            beta,
            c.as_mut_ptr(),
            n as isize,
            1,
        );
    }
}

/// Makes `buffer` at least `length` long. It never becomes shorter, so that its memory is reused for
/// the next batch.
pub(super) fn reserve(buffer: &mut Vec<f32>, length: usize) {
    if buffer.len() < length {
        buffer.resize(length, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_products_agree_with_the_definition() {
        // a is 2 x 3 inside rows of 4, b is 3 x 2.
        let a = [1.0, 2.0, 3.0, 9.0, 4.0, 5.0, 6.0, 9.0];
        let b = [1.0, 0.0, 2.0, 1.0, 0.0, 3.0];
        let a = MatrixView::strided(&a, 2, 3, 4);
        let b = MatrixView::new(&b, 3, 2);
        let mut c = [1.0; 4];
        multiply(a, b, 1.0, &mut c);
        assert_eq!(c, [6.0, 12.0, 15.0, 24.0]);
        let mut gram = [0.0; 9];
        multiply_tn(a, a, 0.0, &mut gram);
        assert_eq!(gram, [17.0, 22.0, 27.0, 22.0, 29.0, 36.0, 27.0, 36.0, 45.0]);
        let mut outer = [0.0; 4];
        multiply_nt(a, a, 0.0, &mut outer);
        assert_eq!(outer, [14.0, 32.0, 32.0, 77.0]);
    }
}
