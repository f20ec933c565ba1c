#include "tumble/tasks/export.hpp"

#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {

std::pair<std::string, std::string> axis_and_file(const std::string& argument) {
  auto named = key_and_value(argument);
  if (named && (named->first.starts_with("gyro_") || named->first.starts_with("accelerometer_"))) return *named;
  return {"", argument};
}

ExportSource export_source(const std::string& argument) {
  auto [axis, file] = axis_and_file(argument);
  auto text = read_text_file(file);
  return {std::move(file), std::move(text), std::move(axis)};
}

std::string export_results(const std::vector<ExportSource>& sources, const ExportWish& wish) {
  const Export& entry = find_export(wish.to);
  std::vector<CalibrationInput> inputs;
  for (const auto& source : sources)
    inputs.push_back({estimate_from_json(source.text, source.file),
                      std::filesystem::path(source.file).filename().string(), sha256_of(source.text), source.axis});
  ExportRequest request{.settings = {}, .drop = wish.drop, .inflate = wish.inflate};
  for (const auto& [key, text] : wish.sets) request.settings.push_back({key, text, "--set", true, true});
  return export_calibration(entry, calibration_of(inputs), request);
}

}  // namespace tumble
