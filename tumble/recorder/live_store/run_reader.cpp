#include "tumble/recorder/live_store/run_reader.hpp"

#include <cmath>

#include "tumble/units/error.hpp"
#include "tumble/wire/frame_findings.hpp"

namespace tumble::live_store {

namespace {

using Severity = Finding::Severity;
const FrameSink nobody = [](const StreamFrame&) {};

}  // namespace

/// The bytes of an instrument are decoded again, so that the counts are exact whatever became of the recorder.
RunReader::RunReader(const StoreContent& content) : links_(content.links.size()) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const StoreLink& link = content.links[i];
    link_of_name_.try_emplace(link.name, i);
    if (link.declaration.empty()) continue;
    links_[i].codec = std::make_unique<FrameCodec>(read_frames(link.declaration, link.declaration_name, link.variants));
    links_[i].stream = std::make_unique<FrameStream>(*links_[i].codec);
  }
}

void RunReader::look(const StoreItem& item) {
  last_ = std::fmax(last_, item.time);
  if (item.event) note(*item.event);
  if (item.journal) note(item.time, *item.journal);
  if (item.kind != StoreItem::Kind::raw || item.source >= links_.size() || !links_[item.source].stream) return;
  FrameStream& stream = *links_[item.source].stream;
  if (item.direction == StoreDirection::received)
    stream.feed(item.bytes, nobody);
  else
    stream.begin_again();
}

void RunReader::note(const StoreEvent& event) {
  if (event.kind == EventKind::clock && started_.empty()) started_ = event.text;
  if (event.kind == EventKind::end) ended_ = true;
  if (event.kind == EventKind::accepted) accepted_.emplace_back(event.who, event.text);
  if (event.kind == EventKind::stopped) stopped_ = event.text, stopped_at_ = event.time;
  if (event.kind != EventKind::link_lost) return;
  const auto link = link_of_name_.find(event.who);
  if (link == link_of_name_.end()) return;
  LinkReader& reader = links_[link->second];
  if (reader.losses++ == 0) reader.first_loss = event.time;
}

void RunReader::note(double time, const RunRow& row) {
  journal_.add(time, row);
  if (row.kind == RunRow::Kind::segment_ends && row.ending == RunRow::Ending::complete && !row.rule.empty())
    rules_[{row.run, row.segment}] = row;
}

Findings RunReader::findings_of_rules() const {
  Findings findings;
  for (const auto& [key, row] : rules_)
    if (row.reached)
      findings.push_back({Severity::info,
                          "ended_by_rule",
                          {{"segment", row.label},
                           {"run", row.run},
                           {"rule", row.rule},
                           {"recorded", *row.reached, "s"},
                           {"at_least", row.at_least, "s"}}});
    else
      findings.push_back(
          {Severity::info,
           "rule_not_met",
           {{"segment", row.label}, {"run", row.run}, {"rule", row.rule}, {"at_least", row.at_least, "s"}}});
  return findings;
}

void RunReader::finish() {
  for (LinkReader& link : links_)
    if (link.stream) link.stream->finish(nobody);
}

Findings RunReader::findings(const StoreContent& content, const std::string& slot) const {
  Findings findings;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const StoreLink& link = content.links[i];
    if (!link.slot.empty() && link.slot != slot) continue;
    if (links_[i].losses > 0)
      findings.push_back({Severity::warning,
                          "recording_link_lost",
                          {{"first_loss", links_[i].first_loss, "s"}},
                          link.name,
                          {links_[i].losses, links_[i].first_loss}});
    if (!links_[i].stream) continue;
    for (Finding& finding : findings_of_stream(*links_[i].codec, links_[i].stream->counts(), link.name))
      if (finding.code != "frames_cut") findings.push_back(std::move(finding));  // every live stream ends so
  }
  for (Finding& finding : findings_of_rules()) findings.push_back(std::move(finding));
  for (const auto& [who, text] : accepted_)
    findings.push_back({Severity::warning, "equipment_expired", {{"who", who}, {"text", text}}});
  if (!stopped_.empty())
    findings.push_back({Severity::warning, "recording_stopped", {{"begin", stopped_at_, "s"}, {"reason", stopped_}}});
  else if (!ended_)
    findings.push_back({Severity::warning, "recording_interrupted", {{"end", last_, "s"}}});
  if (content.damaged > 0) findings.push_back({Severity::error, "recording_damaged", {}, "", {content.damaged}});
  return findings;
}

}  // namespace tumble::live_store
