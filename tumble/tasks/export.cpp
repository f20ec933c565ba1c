#include "tumble/tasks/export.hpp"

#include <filesystem>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/checksum.hpp"
#include "tumble/report/report.hpp"

namespace tumble {

ExportSource export_source(const std::string& argument) {
  const auto equals = argument.find('=');
  const std::string before = argument.substr(0, equals == std::string::npos ? 0 : equals);
  const bool axis = before.starts_with("gyro_") || before.starts_with("accelerometer_");
  const std::string file = axis ? argument.substr(equals + 1) : argument;
  return {file, read_text_file(file), axis ? before : ""};
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
