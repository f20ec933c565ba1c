#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/progress.hpp"
#include "tumble/units/sentence.hpp"

namespace tumble::file {

/// Hands out the lines of a text of any encoding as UTF-8, without their ends, with their numbers from 1.
/// Given  encoding  its name, or empty: by the bytes
/// Throws Error::bad_file.
void each_line(const std::string& path, const std::string& encoding, const Progress& progress,
               const std::function<void(std::string_view line, std::size_t number)>& take);

/// The number that a cell holds [as written], blanks around it allowed; false where it holds none.
/// Given  mark  the decimal mark
bool number_of(std::string_view cell, char mark, double& value);

/// The first ten problems of a file, and how many more there are; none: nothing is thrown. Throws Error::bad_file.
class Problems {
 public:
  explicit Problems(std::string path) : path_(std::move(path)) {}
  void add(std::size_t line, const Sentence& problem);
  void refuse_any() const;

 private:
  std::string path_;
  std::size_t count_ = 0;
  tumble::Problems first_;
};

}  // namespace tumble::file
