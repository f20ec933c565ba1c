#include "tumble/serve/routes/plan_files.hpp"

#include <algorithm>
#include <utility>

#include "tumble/serve/folder_paths.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

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
    auto set = key_and_value(text);
    if (!set || (std::ranges::find(known, set->first) == known.end() && !set->first.starts_with("unit.")))
      throw Error{Error::Kind::bad_input,
                  say("'{}': what a file does not say is rate=100, missing=WORD, unit.COLUMN=deg/h, columns=..., "
                      "segment_column=COLUMN, topic=NAME, decimal=comma, time=COLUMN, date=dmy, encoding=NAME or "
                      "skip=LINES",
                      text)};
    sets.push_back(std::move(*set));
  }
  return sets;
}

}  // namespace tumble::routes
