#include "tumble/formats/frames/findings.hpp"

#include <utility>

#include "tumble/wire/frame_findings.hpp"

namespace tumble::frames {

namespace {

using Severity = Finding::Severity;

void add_identity(const Chosen& chosen, const FrameCounts& counts, const std::string& path, Findings& findings) {
  const FrameCodec& codec = chosen.codec;
  if (chosen.recognised)
    findings.push_back({Severity::info,
                        "frames_recognised",
                        {{"device", codec.title}, {"declaration", codec.name}, {"part", chosen.part, "1"}},
                        path});
  else
    findings.push_back({Severity::info,
                        "frames_read",
                        {{"device", codec.title}, {"declaration", codec.name}, {"frames", counts.channel_frames}},
                        path});
  if (codec.certainty == FrameCertainty::driver || codec.certainty == FrameCertainty::uncertain)
    findings.push_back({Severity::warning, "frames_uncertain", {{"declaration", codec.name}}, path});
}

}  // namespace

Findings findings_of(const Chosen& chosen, const FrameCounts& counts, const std::string& path) {
  Findings findings;
  add_identity(chosen, counts, path, findings);
  for (Finding& finding : findings_of_stream(chosen.codec, counts, path)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace tumble::frames
