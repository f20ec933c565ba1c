#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/formats/csv/layout.hpp"

namespace tumble::csv {

/// From this row on the samples belong to that segment.
struct LabelChange {
  std::size_t row = 0;
  std::string label;
};

/// A fixed number of rows, column after column, in the units of the file.
struct Batch {
  static constexpr std::size_t capacity = 1024;
  std::size_t rows = 0;
  std::vector<double> cells;  ///< capacity for each wanted column
  int time_exponent = 0;      ///< of ten of the last digit written in the time column, the smallest of the rows
  std::vector<LabelChange> labels = {};
  std::vector<std::int64_t> stamps = {};  ///< [ns] of the columns of a clock that is no plain number, capacity for each

  /// The cells of a wanted column, [rows] in use, in the unit of the file.
  const double* column(std::size_t slot) const { return cells.data() + slot * capacity; }
};

/// How much of a line is looked at: all of it, or no more than up to the last cell wanted.
enum class Look { at_all, at_wanted };

/// Turns lines into numbers. Cells that hold no number are noted, and refused all together by finish().
class Rows {
 public:
  Rows(std::string path, const Layout& layout, std::string_view missing, Look look);

  /// Fills the batch from whole lines and moves `text` behind what was used: to its end, or the batch is full.
  void parse(std::string_view& text, Batch& batch);
  /// Throws Error::bad_file when there were bad cells: the first ten with line, column and content, and how many more.
  void finish() const;

  std::size_t slots() const { return slots_; }  ///< wanted columns

 private:
  template <bool blanks>
  const char* plain_text_cell(const char* p, std::size_t column, std::size_t row);
  template <bool blanks>
  const char* plain_row(const char* p, const char* end, std::size_t row);
  const char* any_row(const char* p, const char* end, std::size_t& row);
  bool is_row_of_blanks(std::string_view line) const;
  void take_cells(const std::vector<std::string>& cells, std::size_t row);
  void take_label(std::string_view label, std::size_t row);
  bool take_stamp(std::string_view cell, std::size_t column, std::size_t row);
  bool stamp_column(std::size_t column) const { return stamped_ && layout_.stamp.uses(column); }
  double value_of(std::string cell, std::size_t column);
  void note(std::size_t column, Sentence what);

  std::string path_;
  const Layout& layout_;
  std::string missing_;
  std::size_t slots_ = 0;
  std::vector<int> slot_;         ///< of each column in the batch; -1: not wanted
  std::vector<double*> targets_;  ///< each column of the file in the batch; null: not wanted
  std::size_t time_;              ///< index of the time column, or none
  std::size_t label_;             ///< index of the column of labels, or none
  bool stamped_;                  ///< the clock is no plain number
  std::int64_t* stamp_target_ = nullptr;
  std::size_t looked_at_;  ///< columns, from the first on
  bool labelled_ = false;  ///< a row was read
  std::string last_label_;
  std::vector<LabelChange> labels_;
  int exponent_ = 0;
  std::size_t line_;
  std::size_t blank_lines_ = 0;  ///< of nothing but missing samples, if another sample follows
  std::size_t bad_ = 0;
  Problems notes_;
  bool commas_ = false;  ///< a bad cell would be a number with a decimal comma
  std::string grouped_;  ///< the first bad cell that would be a number with groups of three digits
  std::string word_;     ///< the first bad cell that reads like a missing sample
};

}  // namespace tumble::csv
