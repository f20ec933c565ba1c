#include "tumble/serve/routes/plan_files.hpp"

#include <algorithm>

#include "tumble/serve/folder_paths.hpp"
#include "tumble/units/error.hpp"

namespace tumble::routes {

std::string existing(const Context& context, const std::string& name) {
  try {
    return inside(context.options.folder, name).string();
  } catch (const Error& error) {
    if (error.kind == Error::Kind::bad_file) throw Error{Error::Kind::unsupported, error.problems};
    throw;
  }
}

Sets sets_of(const std::vector<std::string>& texts) {
  static const std::vector<std::string> known{"rate",    "missing", "columns", "segment_column", "topic",
                                              "decimal", "time",    "date",    "encoding",       "skip"};
  Sets sets;
  for (const auto& text : texts) {
    const auto equals = text.find('=');
    const auto key = text.substr(0, equals);
    if (equals == std::string::npos || (std::ranges::find(known, key) == known.end() && !key.starts_with("unit.")))
      throw Error{Error::Kind::bad_input,
                  say("'{}': what a file does not say is rate=100, missing=WORD, unit.COLUMN=deg/h, columns=..., "
                      "segment_column=COLUMN, topic=NAME, decimal=comma, time=COLUMN, date=dmy, encoding=NAME or "
                      "skip=LINES",
                      text)};
    sets.emplace_back(key, text.substr(equals + 1));
  }
  return sets;
}

}  // namespace tumble::routes
