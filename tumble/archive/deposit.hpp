#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tumble/archive/archive.hpp"

/// Deposits into an archive. A second deposit of the same things changes nothing.
namespace tumble {

struct UnitName {
  std::string model, serial;
  bool operator==(const UnitName&) const = default;
};

/// A result of identify.
struct ResultDeposit {
  std::string json, file;  ///< its text, and its name for messages
  UnitName unit = {};      ///< in place of what the result says of its instrument, where not empty
  std::string run = {};    ///< that made its recordings, if any
  std::string station_sha256 = {};
  std::string begun = {}, ended = {};  ///< of the test, UTC; empty: as its recordings say
  std::string corrects = {};           ///< SHA-256 of the result that this one replaces; the act says why
};

/// A file: a recording, a plan, a station, a calibration.
struct FileDeposit {
  std::string path, name;  ///< where it is, and what it is called
  std::string role = {};   ///< "recording", "plan", ...; empty: as the result that was made from it says
  UnitName unit = {};      ///< empty: of the result that was made from it
  std::string run = {}, slot = {};
};

/// An instrument of the laboratory and its calibration.
struct EquipmentDeposit {
  std::string name, maker, model, serial, firmware, location;
  std::string certificate, laboratory;  ///< of its calibration; empty: none is known
  std::string due;                      ///< last day of that calibration, "2027-01-31"
  std::string document_sha256;
  std::string calibrated = {};  ///< day of that calibration
};

struct CertificateDeposit {
  std::string path;    ///< file of the certificate
  std::string result;  ///< SHA-256 of the result
  std::string number, rule, issued_by, issued;
  std::string language = {};  ///< of its words: "en", "zh"; empty: en
  std::vector<EquipmentDeposit> equipment = {};
};

/// Something that happened in a run.
struct ArchivedEvent {
  std::string when, who, action, subject, reason, detail;
};

struct RunDeposit {
  struct Unit {
    std::string slot;
    UnitName unit;
  };
  std::string id;  ///< the same each time it is put in
  std::string title, plan_sha256, station, station_sha256, program_version, who, started, ended, ending;
  std::vector<Unit> units;
  std::vector<EquipmentDeposit> equipment;
  std::vector<ArchivedEvent> events;  ///< in order of time
};

struct Deposit {
  std::vector<EquipmentDeposit> equipment = {};
  std::vector<RunDeposit> runs = {};
  std::vector<ResultDeposit> results = {};
  std::vector<FileDeposit> files = {};
  std::vector<CertificateDeposit> certificates = {};
};

/// How much of a deposit was new.
struct Deposited {
  std::size_t results = 0, files = 0, runs = 0, certificates = 0, equipment = 0;
  std::size_t known = 0;                ///< things that the archive had already
  std::vector<std::string> result_ids;  ///< SHA-256 of its results, in order
};

/// Puts everything in, at most 100 results in a transaction. Files are synchronised before rows name them.
///
/// Throws    Error::bad_input with all that is wrong, before anything is written: a result without a serial number, a
///           recording that no result names, a correction without a reason; Error::bad_file
Deposited put_in(Archive& archive, const Deposit& deposit, const ArchiveAct& act);

}  // namespace tumble
