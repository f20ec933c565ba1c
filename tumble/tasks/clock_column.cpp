#include "tumble/tasks/clock_column.hpp"

#include "tumble/formats/format.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

/// Whether the first block of a file can be read so.
bool can_be_read(const std::string& file, const ReadOptions& options) {
  struct Read {};
  try {
    stream_recording(format_of(file, options), file, options, 1, [](const Recording&) { throw Read{}; }, {});
  } catch (const Read&) {
    return true;
  } catch (const Error&) {
    return false;
  }
  return true;
}

}  // namespace

bool is_clock_column(const std::string& column, const std::string& file, ReadOptions options) {
  options.units.erase(column);
  if (!can_be_read(file, options)) return true;
  options.units[column] = Unit::parse("K");
  return !can_be_read(file, options);
}

}  // namespace tumble
