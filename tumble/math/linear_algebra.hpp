#pragma once

#include <span>
#include <vector>

#include "tumble/math/matrix.hpp"

/// Linear algebra of plain matrices and of vectors of doubles. Sizes that do not fit are an assertion.
namespace tumble {

// ---- vectors ----------------------------------------------------------------------------------------------------

/// Scalar product sum a_i b_i [u v] of vectors [n].
double dot(std::span<const double> a, std::span<const double> b);

/// Length sqrt(sum a_i^2) [u] of a vector [n].
double norm(std::span<const double> a);

/// a - b [u], [n].
std::vector<double> difference(std::span<const double> a, std::span<const double> b);

/// a + factor b [u], [n].
std::vector<double> scaled_sum(std::span<const double> a, double factor, std::span<const double> b);

/// factor a [u], [n].
std::vector<double> scaled(double factor, std::span<const double> a);

/// Element by element: w_i a_i [u], [n].
std::vector<double> scaled(std::span<const double> w, std::span<const double> a);

/// Element by element: 1/max(a_i, least) [1/u], [n], of lengths or standard deviations a_i >= 0; `least` [u] keeps
/// scales finite where a column is zero.
std::vector<double> inverses(std::span<const double> a, double least = 0.0);

// ---- parts of matrices ------------------------------------------------------------------------------------------

/// The identity [n x n].
Matrix identity(std::size_t n);

/// Matrix [n x n] with these values [n] on its diagonal and zeros elsewhere.
Matrix diagonal(std::span<const double> values);

/// Elements [i, i] [min(m, n)] of a matrix [m x n].
std::vector<double> diagonal_of(const Matrix& a);

/// Sum of the diagonal [u] of a matrix [n x n].
double trace(const Matrix& a);

/// A vector [n] as a matrix of one column [n x 1].
Matrix as_column(std::span<const double> values);

/// Column j [m] of a matrix [m x n]: a view that lives as long as the matrix.
std::span<double> column(Matrix& a, std::size_t j);
std::span<const double> column(const Matrix& a, std::size_t j);
std::span<const double> column(const Matrix&& a, std::size_t j) = delete;

/// Row i [n] of a matrix [m x n], a copy.
std::vector<double> row(const Matrix& a, std::size_t i);

/// Elements [rows x columns] from [first_row, first_column] on, a copy.
Matrix block(const Matrix& a, std::size_t first_row, std::size_t rows, std::size_t first_column, std::size_t columns);

/// Put a part [r x c] into a matrix [m x n], from [first_row, first_column] on.
void set_block(Matrix& to, std::size_t first_row, std::size_t first_column, const Matrix& part);

/// The rows named by their indices, in that order: [rows.size() x n] of a matrix [m x n].
Matrix chosen_rows(const Matrix& a, std::span<const std::size_t> rows);

/// The columns named by their indices, in that order: [m x columns.size()] of a matrix [m x n].
Matrix chosen_columns(const Matrix& a, std::span<const std::size_t> columns);

/// One above the other: [m x n] over [l x n] is [m + l x n]. A matrix of no rows and no columns adds nothing.
Matrix stacked(const Matrix& top, const Matrix& bottom);

/// Side by side: [m x n] and [m x l] are [m x n + l]. A matrix of no rows and no columns adds nothing.
Matrix beside(const Matrix& left, const Matrix& right);

/// Transpose [n x m] of a matrix [m x n].
Matrix transposed(const Matrix& a);

/// Lengths [n] of the columns of a matrix [m x n].
std::vector<double> column_norms(const Matrix& a);

// ---- sums and products ------------------------------------------------------------------------------------------

/// Sum and difference, element by element, of matrices [m x n].
Matrix operator+(Matrix a, const Matrix& b);
Matrix operator-(Matrix a, const Matrix& b);
Matrix& operator+=(Matrix& a, const Matrix& b);
Matrix& operator-=(Matrix& a, const Matrix& b);

/// Every element of a matrix [m x n] times `factor` [u].
Matrix operator*(double factor, Matrix a);
Matrix& operator*=(Matrix& a, double factor);

/// Product A B [l x n] of matrices [l x m] and [m x n].
Matrix operator*(const Matrix& a, const Matrix& b);

/// Product A x [m] of a matrix [m x n] and a vector [n].
std::vector<double> operator*(const Matrix& a, std::span<const double> x);

/// A' B [n x l] of matrices [m x n] and [m x l].
Matrix transposed_product(const Matrix& a, const Matrix& b);

/// A' x [n] of a matrix [m x n] and a vector [m].
std::vector<double> transposed_product(const Matrix& a, std::span<const double> x);

/// diag(w) A: row i of a matrix [m x n] times w_i, weights [m].
Matrix scaled_rows(std::span<const double> w, Matrix a);

/// A diag(w): column j of a matrix [m x n] times w_j, weights [n].
Matrix scaled_columns(Matrix a, std::span<const double> w);

/// Outer product a b' [m x n] of vectors [m] and [n].
Matrix outer(std::span<const double> a, std::span<const double> b);

/// Add factor x x' to a matrix [n x n]; `x` [n], `factor` [u].
void add_square(Matrix& to, double factor, std::span<const double> x);

/// A' A, or A' diag(w) A where weights are given: the matrix of normal equations, symmetric to the last bit.
///
/// Given     a  matrix [m x n]
///           w  weights [m] >= 0; none: 1
/// Returned  [n x n]
Matrix gram(const Matrix& a, std::span<const double> w = {});

/// Weighted normal equations A' diag(w) A x = A' diag(w) y.
struct NormalEquations {
  Matrix matrix;              ///< [n x n], symmetric
  std::vector<double> right;  ///< [n]
};

/// Weighted normal equations of A x = y.
///
/// Given     a  design [m x n]
///           w  weights [m], the inverses of variances; none: 1
///           y  observations [m]
/// Returned  matrix A' diag(w) A [n x n], right side A' diag(w) y [n]; solve_symmetric gives x
NormalEquations normal_equations(const Matrix& a, std::span<const double> w, std::span<const double> y);

/// Covariance G V G' of G x, symmetric to the last bit.
///
/// Given     g  [m x n]
///           v  covariance of x [n x n]
/// Returned  [m x m]
Matrix sandwich(const Matrix& g, const Matrix& v);

/// G diag(v) G' [m x m] of a matrix [m x n] and variances [n] of independent quantities, symmetric to the last bit.
Matrix sandwich(const Matrix& g, std::span<const double> v);

/// x' V x [u^2] of a vector [n] and a matrix [n x n]: the variance of a sum with the weights x.
double quadratic_form(std::span<const double> x, const Matrix& v);

// ---- symmetric matrices: only the lower triangle is read --------------------------------------------------------

/// Solve A x = b by A = P' L D L' P with pivots on the diagonal.
///
/// Given     a  symmetric matrix [n x n], positive or negative semidefinite
///           b  right side [n], or several as columns [n x k]
/// Returned  x [n], or [n x k]; a direction with D = 0 gets 0
/// Accuracy  relative to n eps times the condition of A
/// See       Golub and Van Loan, Matrix Computations, 4th ed. (2013), section 4.2
std::vector<double> solve_symmetric(const Matrix& a, std::span<const double> b);
Matrix solve_symmetric(const Matrix& a, const Matrix& b);

/// Inverse [n x n] of a symmetric matrix [n x n] by L D L', symmetric to the last bit: the covariance from an
/// information matrix.
Matrix inverse_symmetric(const Matrix& a);

/// Cholesky factor of a symmetric matrix A = L L'.
struct Cholesky {
  Matrix lower;                  ///< L [n x n]; no elements where A is not positive definite
  double log_determinant = 0.0;  ///< ln det A; not a number where A is not positive definite
  bool positive = false;         ///< A is positive definite, to rounding
};

/// Cholesky factor of a symmetric matrix [n x n].
///
/// Given     a  symmetric matrix [n x n]
/// Returned  L [n x n] with A = L L', and ln det A; `positive` says whether there is one. See symmetric_factor for a
///           matrix that is only semidefinite
/// Accuracy  |A - L L'|_ij below (n + 1) eps sqrt(A_ii A_jj)
/// See       Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), theorem 10.3
Cholesky cholesky(const Matrix& a);

/// Solve L L' x = b, with b [n] or [n x k], by the factor of a positive definite matrix.
std::vector<double> solve(const Cholesky& factor, std::span<const double> b);
Matrix solve(const Cholesky& factor, const Matrix& b);

/// Solve L x = b, with b [n] or [n x k]: whitening, L being the Cholesky factor [n x n] of the covariance of b.
std::vector<double> solve_lower(const Matrix& lower, std::span<const double> b);
Matrix solve_lower(const Matrix& lower, Matrix b);

/// Solve L' x = b, with b [n] or [n x k], for L lower triangular [n x n].
std::vector<double> solve_lower_transposed(const Matrix& lower, std::span<const double> b);
Matrix solve_lower_transposed(const Matrix& lower, Matrix b);

/// Eigenvalues and vectors of a symmetric matrix, A v_k = l_k v_k.
struct SymmetricEigen {
  std::vector<double> values;  ///< [n], ascending
  Matrix vectors;              ///< [n x n]: column k belongs to values[k], of length 1, orthogonal to the others
};

/// Eigenvalues [u] and vectors [1] of a symmetric matrix [n x n], by tridiagonal form and implicit QR steps.
///
/// Accuracy  every eigenvalue to n eps times the greatest
/// See       Golub and Van Loan, Matrix Computations, 4th ed. (2013), section 8.3
SymmetricEigen eigen_symmetric(const Matrix& a);

/// Eigenvalues [u], ascending, of a symmetric matrix [n x n].
std::vector<double> eigenvalues_symmetric(const Matrix& a);

// ---- general systems --------------------------------------------------------------------------------------------

/// Solve A x = b; in the sense of least squares where there are more rows than columns.
///
/// Given     a  matrix [m x n], m >= n
///           b  right side [m], or several as columns [m x k]
/// Returned  x [n], or [n x k]: by LU with row pivots where A is square, by QR with column pivots where it is tall
/// Accuracy  relative to n eps times the condition of A. A singular square matrix gives values that are not finite; a
///           tall one of lower rank gives zeros for the columns that depend on the others
/// See       Golub and Van Loan, Matrix Computations, 4th ed. (2013), sections 3.4, 5.4
std::vector<double> solve(const Matrix& a, std::span<const double> b);
Matrix solve(const Matrix& a, const Matrix& b);

/// Inverse [n x n] of a matrix [n x n] by LU; values that are not finite where it is singular.
Matrix inverse(const Matrix& a);

/// Determinant [u^n] of a matrix [n x n] of [u] by LU; 1 where n = 0.
double determinant(const Matrix& a);

/// A fit by least squares with the rank of its design.
struct QrFit {
  std::vector<double> x;  ///< [n]; 0 for columns that depend on the others
  Matrix root;            ///< [n x rank]: R^-1 in the order of the columns; covariance of x is sigma^2 root root'
  std::size_t rank = 0;   ///< columns that are independent beyond rounding
  double residual_square = 0.0;  ///< |A x - b|^2
};

/// Least squares by QR with column pivots, of any shape.
///
/// Given     a  design [m x n], columns of comparable length
///           b  observations [m]
/// Returned  x [n] with |A x - b| least; the rows of `root` [n x rank] are 0 where x is
/// Accuracy  rank counts the pivots above min(m, n) eps times the greatest
/// See       Golub and Van Loan, Matrix Computations, 4th ed. (2013), section 5.4.2; regression/least_squares.hpp for a
///           fit that names what cannot be observed
QrFit qr_fit(const Matrix& a, std::span<const double> b);

/// Orthogonal factors A = Q R, as Householder reflections.
struct HouseholderQr {
  Matrix packed;                     ///< [m x n]: R on and above the diagonal, the reflections below
  std::vector<double> coefficients;  ///< [min(m, n)], of the reflections
};

/// Orthogonal factors of a matrix [m x n], without pivots: the first k columns of Q span those of A.
HouseholderQr householder_qr(Matrix a);

/// R [min(m, n) x n], zero below the diagonal.
Matrix upper_of(const HouseholderQr& qr);

/// Q B [m x k] of a matrix [m x k]; B of the last columns of the identity gives what is orthogonal to A.
Matrix q_product(const HouseholderQr& qr, Matrix b);

/// Q' b [m] of a vector [m], or Q' B [m x k].
std::vector<double> q_transposed_product(const HouseholderQr& qr, std::span<const double> b);
Matrix q_transposed_product(const HouseholderQr& qr, Matrix b);

/// Least squares x [n], or [n x k], from the factors of a matrix [m x n] of full rank, m >= n.
std::vector<double> solve(const HouseholderQr& qr, std::span<const double> b);
Matrix solve(const HouseholderQr& qr, const Matrix& b);

/// Solve R x = b, with b [n x k], for R upper triangular [n x n].
Matrix solve_upper(const Matrix& upper, Matrix b);

// ---- singular values --------------------------------------------------------------------------------------------

/// Singular values and vectors, A = U diag(values) V' with the first k = min(m, n) columns of V.
struct Svd {
  Matrix u;                    ///< [m x k]
  std::vector<double> values;  ///< [k], descending
  Matrix v;                    ///< [n x n]; the columns beyond those of values above rounding span the null space
};

/// Singular values [u] and vectors [1] of a matrix [m x n], by Jacobi rotations after QR.
///
/// Accuracy  every singular value to n eps times the greatest
/// See       Golub and Van Loan, Matrix Computations, 4th ed. (2013), section 8.6.3
Svd svd(const Matrix& a);

/// Singular values [u], descending, [min(m, n)], of a matrix [m x n]; not numbers where an element is not finite.
std::vector<double> singular_values(const Matrix& a);

/// Ratio [1] of the greatest singular value to the least of a matrix [m x n]; infinite where that is 0.
double condition(const Matrix& a);

/// Pseudo-inverse (Moore and Penrose) by a complete orthogonal decomposition.
///
/// Given     a                   matrix [m x n] of any rank
///           relative_tolerance  [1] pivots below this share of the greatest are 0; 0: min(m, n) eps
/// Returned  [n x m]
/// See       Golub and Van Loan, Matrix Computations, 4th ed. (2013), sections 5.4.7, 5.5.2
Matrix pseudo_inverse(const Matrix& a, double relative_tolerance = 0.0);

}  // namespace tumble
