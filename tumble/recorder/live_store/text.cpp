// What a store says in words: events, the journal, and what links and streams are, as JSON.

#include "tumble/recorder/live_store/text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "tumble/core/json_text.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/units/error.hpp"

namespace tumble::live_store {

namespace {

using Json = nlohmann::json;

/// What the caller wrote as JSON, or as a text where it is not JSON.
Json value_of(const std::string& json) {
  Json value = Json::parse(json, nullptr, false);
  return value.is_discarded() ? Json(json) : value;
}

std::string more_of(const Json& json) { return json.contains("more") ? json_text(json["more"]) : std::string(); }

/// The state that an event says was entered; absent: it is about none. A store of version 1 says it in its text alone.
std::optional<RunPhase> phase_of(const Json& json, const std::string& text) {
  const std::string word = json.value("phase", "");
  for (const RunPhase phase : all_phases()) {
    if (word == name(phase)) return phase;
    for (const RunPhase from : all_phases())
      if (word.empty() && text == fmt::format("{} -> {}", name(from), name(phase))) return phase;
  }
  return std::nullopt;
}

StoreEvent event_of(const Json& json, double time) {
  const std::string text = json.value("text", "");
  const Sentence said = json.contains("text_said") ? sentence_from_json(json_text(json["text_said"])) : Sentence(text);
  StoreEvent event{time, event_kind(json.value("kind", "")), json.value("who", ""), said, more_of(json)};
  if (event.kind == EventKind::phase) event.phase = phase_of(json, text);
  return event;
}

/// A row, or what stands for it in a store of version 1. There the recorder had steps of its own, of which those that
/// begin and end an attempt repeat a row: nothing then.
std::optional<RunRow> row_of_chunk(const Chunk& chunk, const Json& json) {
  if (!json.contains("step")) return row_of(std::string(chunk.body));
  const std::string step = json.value("step", "");
  if (step != "records" && step != "pauses") return std::nullopt;
  RunRow row;
  row.kind = step == "records" ? RunRow::Kind::records : RunRow::Kind::pauses;
  row.time = chunk.begin;
  row.label = json.value("segment", "");
  row.segment = json.value("index", std::size_t{0});
  row.attempt = json.value("attempt", 1);
  row.run = json.value("run", 1);
  return row;
}

/// The row that an event of a store of version 1 holds; nothing where nobody can read it, or it is another event.
std::optional<RunRow> row_of_event(const Json& json) try {
  if (json.value("kind", "") != "journal") return std::nullopt;
  return row_of(more_of(json));
} catch (const Error&) {
  return std::nullopt;
}

[[noreturn]] void refuse_description() {
  throw Error(Error::Kind::bad_file, "the live store describes a link or a stream in an unknown way");
}

template <class Read>
auto described(std::string_view text, Read read) {
  try {
    return read(Json::parse(text));
  } catch (const Json::exception&) {
    refuse_description();
  }
}

}  // namespace

void put_event(Chunk& chunk, std::uint64_t sequence, const StoreEvent& event) {
  Json json{{"kind", name(event.kind)}};
  if (!event.who.empty()) json["who"] = event.who;
  if (!event.text.empty()) json["text"] = event.text.text();
  if (const auto said = sentence_to_json(event.text); !said.empty()) json["text_said"] = Json::parse(said);
  if (event.phase) json["phase"] = name(*event.phase);
  if (!event.json.empty()) json["more"] = value_of(event.json);
  put_text(chunk, sequence, event.time, json_text(json));
}

void put_journal(Chunk& chunk, std::uint64_t sequence, double time, const RunRow& row) {
  put_text(chunk, sequence, time, text_of(row));
}

bool items_of_text(const Chunk& chunk, const std::function<void(const StoreItem&)>& visit) {
  const Json json = Json::parse(chunk.body, nullptr, false);
  if (!json.is_object()) return false;
  StoreItem item{.kind = chunk.kind, .sequence = chunk.first, .time = chunk.begin};
  try {
    const bool is_row = chunk.kind == StoreItem::Kind::journal;
    const auto row = is_row ? row_of_chunk(chunk, json) : row_of_event(json);
    if (is_row && !row) return true;
    std::optional<StoreEvent> event;
    if (!row) event = event_of(json, chunk.begin);
    item.kind = row ? StoreItem::Kind::journal : StoreItem::Kind::event;
    item.journal = row ? &*row : nullptr;
    item.event = event ? &*event : nullptr;
    visit(item);
  } catch (const Error&) {
    return false;
  } catch (const Json::exception&) {
    return false;
  }
  return true;
}

std::string json_of(const StoreLink& link) {
  Json json{{"name", link.name}, {"slot", link.slot}};
  if (!link.declaration.empty())
    json["instrument"] = {
        {"name", link.declaration_name}, {"declaration", link.declaration}, {"variants", link.variants}};
  return json_text(json);
}

std::string json_of(const StoreStream& stream) {
  Json json{{"name", stream.name}, {"slot", stream.slot}, {"rate", stream.rate}};
  if (stream.link) json["link"] = *stream.link;
  json["channels"] = Json::array();
  for (const FrameChannel& channel : stream.channels)
    json["channels"].push_back(
        {{"name", channel.name}, {"unit", channel.unit.text()}, {"increment", channel.increment}});
  return json_text(json);
}

StoreLink link_of(std::string_view text) {
  return described(text, [](const Json& json) {
    StoreLink link{json.value("name", ""), json.value("slot", "")};
    if (!json.contains("instrument")) return link;
    const Json& instrument = json["instrument"];
    link.declaration_name = instrument.value("name", "");
    link.declaration = instrument.value("declaration", "");
    link.variants = instrument.value("variants", std::vector<std::string>{});
    return link;
  });
}

StoreStream stream_of(std::string_view text) {
  return described(text, [](const Json& json) {
    StoreStream stream{json.value("name", ""), json.value("slot", ""), {}, json.value("rate", 0.0)};
    if (json.contains("link")) stream.link = json["link"].get<std::size_t>();
    for (const Json& channel : json.at("channels"))
      stream.channels.push_back(
          {channel.value("name", ""), Unit::parse(channel.value("unit", "1")), channel.value("increment", false)});
    return stream;
  });
}

}  // namespace tumble::live_store
