#pragma once

#include <string>
#include <vector>

#include "archive_options.hpp"

namespace tumble::cli {

/// The command line of `tumble archive`.
struct ArchiveArguments {
  std::string action;
  std::vector<std::string> what;
  ArchiveOptions archive;
  std::string files, unit, model, replaces, within = "30 day", output, date, lab, kind, text, parameter, minimum,
                                            maximum, figure, baseline;
  bool json = false, every_day = false;
};

/// The only word that an action takes. Throws Error::bad_input.
const std::string& only_word(const ArchiveArguments& arguments, const std::string& name);
void no_words(const ArchiveArguments& arguments);

/// What changes an archive: each returns the exit status.
int archive_init(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_ingest(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_note(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_withdraw(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_export(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_import(const ArchiveArguments& arguments, const Terminal& terminal);

/// What looks at one.
int archive_list(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_show(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_history(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_chart(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_summary(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_due(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_verify(const ArchiveArguments& arguments, const Terminal& terminal);
int archive_recompute(const ArchiveArguments& arguments, const Terminal& terminal);

}  // namespace tumble::cli
