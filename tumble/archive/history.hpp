#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/archive/deposit.hpp"
#include "tumble/core/estimate.hpp"

/// Contents of an archive. All functions throw Error::bad_file where it cannot be read.
namespace tumble {

struct ArchivedUnit {
  UnitName name;
  std::size_t results = 0;
  std::string first, last;  ///< when the first and the last result were made, UTC
};

struct ArchivedResult {
  std::string sha256;
  UnitName unit;
  std::string run, method, title, program_version, verdict, who;
  std::string begun, ended, archived;  ///< UTC; times of the test are empty where they are not known
  bool simulated = false;
  std::string replaced_by, correction;  ///< SHA-256 of the result that replaces it, and why; empty: it counts
};

struct ArchivedFile {
  std::string sha256, role, name, run, slot;
  std::int64_t bytes = 0;
};

struct ArchivedCertificate {
  std::string sha256, number, result, format, issued_by, issued;
};

struct ArchivedRun {
  std::string id, title, station, who, started, ended, ending, slot;
};

/// An event of a chain.
struct ArchivedStep {
  std::int64_t number = 0;
  std::string when, who, action, subject, reason, detail;
};

/// A signature under a result or a certificate (signatures.hpp).
struct Signature {
  std::int64_t number = 0;  ///< of its event
  std::string kind, sha256, meaning, who, when, why;
  std::string problem;  ///< why it does not hold; empty: the archive has exactly what was signed
};

/// Everything about one unit, in order of time.
struct UnitRecord {
  UnitName name;
  std::vector<ArchivedResult> results;
  std::vector<ArchivedFile> files;
  std::vector<ArchivedCertificate> certificates;
  std::vector<ArchivedRun> runs;
  std::vector<ArchivedStep> steps;
  std::vector<Signature> signatures = {};
};

/// Everything about one run, in order of time.
struct RunRecord {
  ArchivedRun run;                                             ///< slot: empty
  std::vector<std::pair<std::string, UnitName>> units;         ///< by slot
  std::vector<std::pair<std::string, std::string>> equipment;  ///< name and certificate
  std::vector<ArchivedStep> steps;
};
/// The run whose id begins with these digits, six or more; nothing if no id does. Throws Error::bad_input where several
/// begin so.
std::optional<RunRecord> find_run(const Archive& archive, const std::string& digits);

/// All units in order of model and serial number; `model`: those of one model, empty: of all.
std::vector<ArchivedUnit> archived_units(const Archive& archive, const std::string& model = {});

/// The unit that a person means by SERIAL or MODEL/SERIAL. Throws Error::bad_input where no unit is known by these
/// words, or several models have the serial number.
UnitName find_unit(const Archive& archive, const std::string& words);

UnitRecord unit_record(const Archive& archive, const UnitName& unit);

/// Names of the parameters that the newest results have, of one unit or where it is empty of a model: what charts may
/// be asked for. In the order in which results have them.
std::vector<std::string> charted_parameters(const Archive& archive, const std::string& model,
                                            const UnitName& unit = {});

/// SHA-256 of the result that begins with these digits, six or more. Throws Error::bad_input where no result, or more
/// than one, begins so.
std::string find_result(const Archive& archive, const std::string& digits);

/// SHA-256 of results by their numbers (ChartValue::result); one that is not there has none.
std::map<std::int64_t, std::string> sha256_by_number(const Archive& archive, const std::vector<std::int64_t>& numbers);

/// The text of a result, as it was put in. Throws Error::bad_file where its bytes have changed.
std::string result_text(const Archive& archive, const std::string& sha256);

/// A file that the archive keeps: a recording, a plan, a certificate.
struct StoredFile {
  std::string sha256, name;
};
/// The file whose SHA-256 begins with these digits, six or more; nothing if no file does. Throws Error::bad_input where
/// several begin so.
std::optional<StoredFile> find_file(const Archive& archive, const std::string& digits);
/// Writes it, with the bytes that it had. Throws Error::bad_file where these have changed, or cannot be written.
void write_stored(const Archive& archive, const std::string& sha256, const std::string& path);

/// A file that a result was made from.
struct ArchivedInput {
  std::string role, sha256, name;
  bool stored = false;  ///< whether the archive has the file itself
};
std::vector<ArchivedInput> inputs_of_result(const Archive& archive, const std::string& sha256);

/// A value of a parameter in a result that counts.
struct ChartValue {
  std::int64_t unit = 0, result = 0;  ///< numbers of their rows
  double moment = 0.0;                ///< [s] since 1970
  double value = 0.0, sd = 0.0;       ///< [SI]
  double private_sd = 0.0;            ///< [SI], of the errors that no other result shares
  std::int64_t sources = 0;           ///< which errors are shared, as a number: equal where they are the same; 0: none
};

struct ParameterOverUnits {
  std::string parameter;
  Unit shown;  ///< that people are shown
  std::vector<ChartValue> values;
  std::vector<std::pair<std::int64_t, UnitName>> units;  ///< names by number, in order of the number
};

/// All values of a parameter in order of time; results that were replaced are not among them.
///
/// Given     parameter  name; results name it
///           model      of the units; empty: of all
///           unit       of one unit; empty: of all
/// Throws    Error::bad_input where no result of these units has the parameter
ParameterOverUnits parameter_over_units(const Archive& archive, const std::string& parameter, const std::string& model,
                                        const UnitName& unit = {});

/// A calibration of an instrument of the laboratory that ends.
struct DueCalibration {
  std::string equipment, certificate, laboratory, due;
};

/// The last calibration of each instrument, where it ends on that day ("2026-12-31") or before, the earliest first.
std::vector<DueCalibration> due_calibrations(const Archive& archive, const std::string& until);

}  // namespace tumble
