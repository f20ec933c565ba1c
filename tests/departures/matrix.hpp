#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/departures/judgement.hpp"
#include "tumble/methods/testing/trials.hpp"

/// The matrix of methods and departures.
namespace tumble::departures {

/// One of the two trials of a method.
struct Subject {
  const Method* method = nullptr;
  Trial (*draw)(std::uint64_t seed) = nullptr;
  bool second = false;
};
std::string name(const Subject& subject);  ///< "allan_noise", "allan_noise.second"
std::vector<Subject> all_subjects();

/// One cell. Its name has no blank: "allan_noise/clock_fast/x10".
struct Cell {
  const Departure* departure = nullptr;
  std::string target;
  std::size_t size = 0;  ///< index in sizes_of
};
std::string name(const Subject& subject, const Cell& cell, std::size_t sizes);

/// Whether a method, departure and target are among `percent` of all, the same ones in each run: by a hash of their name.
bool is_drawn(const std::string& name, double percent);

/// The sound tests of a subject, with their answers, and the verdicts of its cells.
struct Row {
  std::string cell;
  std::string unit = {};
  double size = 0.0;  ///< [unit], or [SI] where there is none
  CellVerdict verdict = {};
  std::string parameter = {};  ///< with the greatest deviation
  std::string first_refusal = {};
  bool follows = false;  ///< it holds, since it holds at a greater size
};
struct Matrix {
  Accusations sound;
  std::vector<Row> rows;
  std::vector<std::string> impossible;  ///< cells whose test cannot be made, with the reason
};
Matrix matrix_of(const Subject& subject, double percent, std::size_t seeds);

/// As lines of tables: what script/departures joins.
std::string text_of(const std::string& subject, const Matrix& matrix);

}  // namespace tumble::departures
