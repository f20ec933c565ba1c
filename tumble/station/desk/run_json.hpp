#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tumble/station/desk/curves.hpp"
#include "tumble/station/run_desk.hpp"

/// A run as JSON: what a desk answers, and what is read of a run that has ended.
namespace tumble::desk {

using Json = nlohmann::ordered_json;

std::string dumped(const Json& json);

/// Numbers as they are drawn, and texts of numbers. Times [s] since the begin of this process.
Json json_of(const RunView& view, double speed);
Json json_of(const Curves& curves);
Json json_of(const EstimateHistory& history);
/// Time [s] of the store's clock; of the rows of the journal their steps too.
Json json_of(std::uint64_t sequence, const StoreEvent& event);
Json json_of(const RunFacts& facts);
/// State of each segment: "done", "skipped", "now" or "next", and how often it was begun.
Json json_of(const std::vector<SegmentProgress>& progress, std::size_t now);

}  // namespace tumble::desk
