#pragma once

#include <string>
#include <vector>

#include "tumble/exchange/certificate.hpp"
#include "tumble/tasks/tasks.hpp"

namespace tumble {

/// Statements of a laboratory about a calibration, from its file. `sets` are values by "section.key", which replace
/// those of the file; an image of `[laboratory] logo` is read too.
/// Throws Error::bad_input with all that is unknown or wrong, each with its line; Error::bad_file.
CertificateDetails load_lab(const std::string& path, const Sets& sets);

/// The certificate on a result file, with the validation of its plan as an annex where its file is named. A validation of another
/// text of the plan is noted.
/// Throws as certify(), and Error::bad_file; Error::bad_input for a file that is no validation
Certificate certificate_on(const std::string& result_file, const CertificateDetails& details,
                           const std::string& validation_file = {});

}  // namespace tumble
