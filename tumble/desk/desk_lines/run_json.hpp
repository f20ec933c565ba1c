#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tumble/desk/desk_lines/curves.hpp"
#include "tumble/desk/run_desk.hpp"
#include "tumble/recorder/recorder_read.hpp"

/// A run as JSON: what a desk answers, and what is read of a run that has ended.
namespace tumble::desk_lines {

using Json = nlohmann::ordered_json;

/// Adds the English text of a sentence as a member, and its pattern and values as <member>_said.
void put_said(Json& json, const std::string& member, const Sentence& said);

/// Numbers as they are drawn, and texts of numbers. Times [s] since the begin of this process.
Json json_of(const RunView& view, double speed);
Json json_of(const Curves& curves);
Json json_of(const EstimateHistory& history);
/// Time [s] of the store's clock; of rows of the journal their steps too.
Json json_of(std::uint64_t sequence, const StoreEvent& event);
Json json_of(std::uint64_t sequence, double time, const RunRow& row);
/// Whether people see the item: an event, or a row of the journal that says more than that recording goes on.
bool is_shown(const StoreItem& item);
Json json_of(const StoreItem& item);
Json json_of(const RunFacts& facts);
/// State of each segment: "done", "skipped", "now" or "next", and how often it was begun.
Json json_of(const std::vector<SegmentProgress>& progress, std::size_t now);

}  // namespace tumble::desk_lines
