#pragma once

#include <string>
#include <vector>

#include "tumble/core/finding.hpp"

namespace tumble {

/// Findings about one recording.
struct NoticedIn {
  std::string file;
  Findings findings;
};

/// The findings of several recordings, those of one kind as one: 60 files with the same fault are said once.
///
/// Given     noticed  by recording
///
/// Returned  in the order in which each kind is first met. Of one recording: its findings as they are. Of several: the
///           first of each kind and severity, `where` with its file and the number of other places, and the occurrences
///           summed, with the file where most are as the worst place
Findings gathered(const std::vector<NoticedIn>& noticed);

}  // namespace tumble
