#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tumble/departures/judgement.hpp"
#include "tumble/methods/testing/trials.hpp"

/// The matrix of methods and departures.
namespace tumble::departures {

/// One cell. Its name has no blank: "allan_noise/clock_fast/x10".
struct Cell {
  const Departure* departure = nullptr;
  std::string target;
  std::size_t size = 0;  ///< index in sizes_of
};
std::string name(const Method& method, const Cell& cell, std::size_t sizes);

/// Whether a method, departure and target are among `percent` of all, the same ones in each run: by a hash of their name.
bool is_drawn(const std::string& name, double percent);

/// The verdict of a cell.
struct Row {
  std::string cell;
  std::string unit = {};
  double size = 0.0;  ///< [unit], or [SI] where there is none
  CellVerdict verdict = {};
  std::string parameter = {};  ///< with the greatest deviation
  std::string first_refusal = {};
  bool follows = false;  ///< it holds, since it holds at a greater size
};
/// Which cells are run.
struct Drawn {
  double percent = 100.0;      ///< of them
  std::string departure = {};  ///< of this departure alone; empty: of all
};
/// The cells of a method, by its first trial, and what it makes of the sound tests.
struct Matrix {
  Accusations sound;
  std::size_t parameters = 0, judged = 0;  ///< of the truth, and those of which a sound test gives a value
  std::vector<Row> rows;
  std::vector<std::string> impossible;  ///< cells whose test cannot be made, with the reason
};
Matrix matrix_of(const Method& method, const Drawn& drawn, std::size_t seeds);

/// How many of the first trials of a method, seeds `first` to `first + seeds - 1`, are accused although they are sound.
Accusations accusations_of(const Method& method, std::uint64_t first, std::size_t seeds);

/// As lines of tables: what script/departures joins.
std::string text_of(const Method& method, const Matrix& matrix);

}  // namespace tumble::departures
