#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/format.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/kind_of_file.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"
#include "verbs.hpp"

namespace tumble::cli {

namespace fs = std::filesystem;

Argument sets_argument(std::vector<std::string>& texts, std::string what) {
  return {.name = "--set", .value = &texts, .description = std::move(what), .type = "KEY=VALUE"};
}

Argument reading_sets(std::vector<std::string>& texts, const std::string& before) {
  return sets_argument(texts, before +
                                  " does not contain:\n"
                                  "rate=100, missing=WORD, unit.COLUMN=deg/h,\n"
                                  "columns=\"time[s],x[deg/s]\" for a file without a header,\n"
                                  "segment_column=COLUMN with labels, decimal=comma,\n"
                                  "time=COLUMN, date=dmy, encoding=gb18030, skip=LINES; repeatable");
}

Argument topic_argument(std::vector<std::string>& topics) {
  return {.name = "--topic",
          .value = &topics,
          .description = "of a log with several streams: the one to read; repeatable",
          .type = "NAME"};
}

Argument departure_argument(std::vector<std::string>& departures) {
  return {.name = "--departure",
          .value = &departures,
          .description =
              "in which the test departs from its plan: see `tumble list departures`;\nclock_fast=\"300 ppm\", "
              "positions_offset:head=\"20 arcsec\"; repeatable",
          .type = "NAME[:TARGET][=SIZE]"};
}

tumble::Sets parse_sets(const std::vector<std::string>& texts, const std::vector<std::string>& topics) {
  tumble::Sets sets;
  for (const auto& topic : topics) sets.emplace_back("topic", topic);
  Problems problems;
  for (const auto& text : texts) {
    auto set = key_and_value(text);
    if (!set)
      problems.push_back(say("--set {0}: write --set {0}=VALUE, without a blank", Name{text}));
    else if (set->first.empty())
      problems.push_back(say("--set {}: write --set key=value", Name{text}));
    else
      sets.push_back(std::move(*set));
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
  return sets;
}

Estimate read_result(const std::string& path) {
  if (path != "-") refuse_other_kind(path, FileKind::result);
  return estimate_from_json(read_text_file(readable(path)), path == "-" ? "standard input" : path);
}

void write_output(const Terminal& terminal, const std::string& path, const std::string& content) {
  if (path == standard_output) return print(content);
  write_file_atomically(path, content);
  note(terminal, say("wrote {}", Name{path}));
}

void write_figures(const std::vector<Figure>& originals, const std::string& path, Language language,
                   const Terminal& terminal) {
  const auto figures = in_language(language, originals);
  const fs::path all(path);
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const auto one = figures.size() == 1 ? all
                                         : all.parent_path() / fmt::format("{}-{}{}", all.stem().string(), i + 1,
                                                                           all.extension().string());
    write_file_atomically(one.string(), to_svg(figures[i]));
    note(terminal, say("wrote {}: {}", Name{one.string()}, Name{figures[i].name}));
  }
}

void check_output(const std::string& option, const std::string& output, const std::vector<std::string>& inputs,
                  const std::vector<std::string>& extensions) {
  if (output == standard_output) return;
  Problems problems;
  const fs::path path(output);
  const auto extension = path.extension().string();
  if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end())
    problems.push_back(say("{} {}: the name must end in {}", Name{option}, Name{output}, fmt::join(extensions, ", ")));
  std::error_code unknown;
  const auto folder = path.parent_path();
  if (!folder.empty() && !fs::is_directory(folder, unknown))
    problems.push_back(say("{} {}: there is no folder {}", Name{option}, Name{output}, Name{folder.string()}));
  for (const auto& input : inputs)
    if (fs::equivalent(path, input, unknown))
      problems.push_back(
          say("{} {}: would overwrite the input {}; choose another name", Name{option}, Name{output}, Name{input}));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

void check_recording_output(const std::string& output, const std::vector<std::string>& inputs) {
  std::vector<std::string> extensions;
  const auto extension = fs::path(output).extension().string();
  for (const auto* format : format_catalogue())
    if (format->writer)
      extensions.insert(extensions.end(), format->extensions.begin(), format->extensions.end());
    else if (std::ranges::find(format->extensions, extension) != format->extensions.end())
      format_to_write(output);  // says that the format is only read
  check_output("-o", output, inputs, extensions);
}

}  // namespace tumble::cli
