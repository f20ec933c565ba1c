#pragma once

#include <string_view>

namespace tumble::file {

/// Whether a file that begins so is a LabVIEW Measurement file (LVM).
bool is_labview(std::string_view beginning);

/// Whether a file that begins so holds datasets of the Universal File Format: "    -1", then the number of a dataset.
bool is_universal(std::string_view beginning);

}  // namespace tumble::file
