#pragma once

#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/math/regression/mixed_model.hpp"

/// An answer is assembled from lines of its budget: the covariance is their sum by construction.
///
///   C = sum_s B_s B_s'            B_s: p x q, signed, column k the shift of the p parameters by error k at one sd
///
/// A method names its parameters, makes one line for each source of uncertainty by a function `from_...`, and calls
/// `settle`.
namespace tumble {

/// A line of the budget in the making.
struct ErrorLine {
  std::string source;  ///< as people read it: "output noise"
  Matrix factor;       ///< B_s [SI] p x q
  std::string key;     ///< see Contribution
  /// p: with how many degrees of freedom the line's variance of each parameter is known; empty: it is known.
  std::vector<double> degrees_of_freedom;
};

/// Errors with known signs.
///
/// Given     shifts  [SI] p x q: column k holds the shift of each parameter by independent error k at one standard
///                   deviation
///           key     what another result must share for the errors to be the same; empty: nothing
ErrorLine from_shifts(std::string source, Matrix shifts, std::string key = {});

/// Errors of which only the covariance is known: a factor is taken of it, whose signs mean nothing to other results, so
/// that the line has no key.
///
/// Given     covariance  [SI] p x p, symmetric, positive semidefinite
///           scale       [SI^2] p, against which rounding is judged; empty: its own diagonal
/// Throws    Error::internal where it is not positive semidefinite within 1e-9 of the scale
ErrorLine from_covariance(std::string source, const Matrix& covariance, const std::vector<double>& scale = {});

/// Errors of inputs that the parameters are functions of: J C J'.
///
/// Given     gradients   J, p x n: derivative of parameter i by input j
///           covariance  of the inputs [SI] n x n
/// Throws    as from_covariance
ErrorLine from_gradients(std::string source, const Matrix& gradients, const Matrix& covariance);

/// Independent errors of single parameters with these variances [SI^2] (p).
ErrorLine from_variances(std::string source, const std::vector<double>& variances);

/// One line for each source of a fit, p rows each: signed, with its key, where the fit says its shifts. Rounding is
/// judged against the variances of all of them together.
std::vector<ErrorLine> lines_of(const std::vector<SourceCovariance>& sources);

/// The line of the inputs [n rows] as one of the parameters [p rows] with these gradients [p x n, SI].
/// Degrees of freedom stay where every input has the same.
///
/// Throws    Error::internal where they differ
ErrorLine carried(const Matrix& gradients, ErrorLine inputs);
/// All lines of the inputs, each as above; gradients [p x n, SI].
std::vector<ErrorLine> carried(const Matrix& gradients, std::vector<ErrorLine> inputs);

/// Covariance [SI] (p x p) by lines of p rows, as `settle` has it.
Matrix covariance_of(const std::vector<ErrorLine>& lines, std::size_t parameters);

/// Gives the estimate its budget, its covariance, and where a line states degrees of freedom those of the parameters:
///
///   nu_i = v_i^2 / sum_s (v_is^2/nu_is)        v_i = sum_s v_is        (Welch and Satterthwaite)
///
/// at least 1. Lines of one source without a key become one line of independent errors. Lines of one source and one
/// key are the same errors: their factors are added. Lines that give nothing go.
///
/// Given     estimate  with all its parameters
/// Throws    Error::internal where a factor has not one row a parameter, or lines of one key differ in columns
/// See       Welch, Biometrika 34 (1947) 28; Satterthwaite, Biometrics Bull. 2 (1946) 110
void settle(Estimate& estimate, const std::vector<ErrorLine>& lines);

/// Adds the parameters of `part` after those of `sum`, with budget and covariance. Lines of one source and one key
/// are the same errors and give the covariance between the two; all other lines are independent of each other, and of
/// one source they share a line. Findings, tables and curves follow those of `sum`; of the fit, observations, degrees
/// of freedom and chi-square are added.
void append(Estimate& sum, const Estimate& part);

/// Adds one parameter with the variance [SI^2] that `source` gives it, independent of all others.
void append_parameter(Estimate& estimate, Parameter parameter, const std::string& source, double variance);

/// The estimate with `findings` of the data before its own.
Estimate finished(Estimate estimate, const Findings& findings);

/// Removes parameter number `index`, with its row of the budget and the findings about it alone; everything else stays.
void remove_parameter(Estimate& estimate, std::size_t index);

}  // namespace tumble
