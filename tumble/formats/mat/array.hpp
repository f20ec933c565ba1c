#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tumble/formats/file/budget.hpp"
#include "tumble/formats/file/series.hpp"

namespace tumble::mat {

/// A numeric variable or field with its values [as written], by the longer side: of 1000 x 3 and of 3 x 1000 there are
/// three vectors of 1000.
struct Array {
  std::string name;  ///< "gyro", "imu.gyro"
  std::vector<std::shared_ptr<file::Series>> vectors;

  /// `count` vectors without values, which go to the spool if there is one.
  Array(std::string name, std::size_t count, const std::shared_ptr<file::Spool>& spool);
  std::size_t length() const { return vectors.empty() ? 0 : vectors.front()->size(); }
};

/// Where the numbers of a file go.
enum class Keep { in_memory, in_spool, sizes_only };

/// Contents of a MATLAB file. What is kept is counted: a member that keeps something throws Error::bad_file, the bare reason,
/// where no file of this size can hold it.
struct Contents {
  Contents(const std::string& path, Keep keep);

  void keep_array(Array array);
  void keep_text(const std::string& variable, std::string text);
  /// A variable that holds no plain numbers. The first ones keep their names.
  void leave_out(const std::string& variable);

  Keep keep;
  std::shared_ptr<file::Spool> spool;  ///< null: in memory
  std::uintmax_t numbers = 0;          ///< in all arrays [1]
  std::vector<Array> arrays;
  std::vector<std::pair<std::string, std::string>> texts;  ///< by the name of the variable
  std::vector<std::string> skipped;                        ///< variables that hold no plain numbers, the first ones
  std::size_t skipped_too = 0;                             ///< [1] and so many more
  std::string head;                                        ///< what the file says of itself
  bool cut_off = false;                                    ///< it ends within a variable; what is whole is here
  file::Budget budget;
};

/// Fills an array, without values and min(rows, columns) wide, with values that come column by column.
class Filler {
 public:
  /// `room`: values [1] for which memory is asked at once; more is asked for as they come.
  Filler(Array& to, std::size_t rows, std::size_t columns, std::size_t room);
  /// The next `count` values [any], at most as many as there is room for.
  void add(const double* values, std::size_t count);

 private:
  Array& to_;
  std::size_t rows_;
  bool by_column_;  ///< a vector is a column, not a row
  std::size_t next_ = 0;
};

/// MATLAB's binary files of version 5 (6, 7) and 4. Throws Error::bad_file.
Contents read_level5(const std::string& path, Keep keep);
Contents read_level4(const std::string& path, Keep keep);
/// Version 7.3: HDF5. Throws Error::bad_file.
Contents read_hdf5(const std::string& path, Keep keep);

/// Whether the file begins as one of version 4, which has no signature.
bool is_level4(const std::string& path);

}  // namespace tumble::mat
