#pragma once

#include "archive_options.hpp"

namespace tumble::cli {

/// Reads the prior of a plan that says `prior = "archive"` from the archive that --archive or TUMBLE_ARCHIVE names.
/// Every other plan stays as it is. Throws as read_prior().
void read_prior_from(const ArchiveOptions& options, Plan& plan);

}  // namespace tumble::cli
