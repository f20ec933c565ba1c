#pragma once

#include <string>

#include "tumble/core/estimate.hpp"
#include "tumble/core/recording.hpp"
#include "tumble/core/text.hpp"

namespace tumble {

/// The result JSON of the public contract: values, sd, covariance and budget in the displayed unit of each parameter.
std::string to_json(const Estimate& estimate);
/// Findings alone: the array of the result JSON.
std::string to_json(const Findings& findings);
/// A result from its JSON. `file` is for messages. Throws Error::bad_file with what is missing or wrong.
Estimate estimate_from_json(const std::string& text, const std::string& file);

/// Settings of a page that do not come from the result.
struct PageOptions {
  std::string title = {};  ///< in place of that of the result; empty: that one
  std::string logo = {};   ///< data_uri_of_image(); empty: none
  Language language = Language::english;
};

/// One self-contained page: parameters, budget, figures, findings, verdicts, provenance. Works offline, prints.
std::string to_html(const Estimate& estimate, const PageOptions& page = {});

/// Readable terminal text with lines of at most `width` characters where its tables allow it. Values carry their
/// uncertainty to two digits: 6.660 ± 0.011; in Chinese in two columns, since "±" is an expanded uncertainty there.
std::string to_text(const Estimate& estimate, std::size_t width = 100, Language language = Language::english);
/// Findings from the array that `to_json` gives. Throws Error::bad_file.
Findings findings_from_json(const std::string& text, const std::string& file);
/// Lines for a terminal: "  warning: message (where)", or that nothing was found.
std::string to_text(const Findings& findings, std::size_t width, Language language = Language::english);

/// value and sd [unit shown] rounded together for people: "6.660 ± 0.011".
std::string with_uncertainty(double value, double sd);

}  // namespace tumble
