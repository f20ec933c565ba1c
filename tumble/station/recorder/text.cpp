// What a store says in words: events, the journal, and what links and streams are, as JSON.

#include "tumble/station/recorder/text.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "tumble/units/error.hpp"

namespace tumble::recorder {

namespace {

using Json = nlohmann::json;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// What the caller wrote as JSON, or as a text where it is not JSON.
Json value_of(const std::string& json) {
  Json value = Json::parse(json, nullptr, false);
  return value.is_discarded() ? Json(json) : value;
}

std::string more_of(const Json& json) { return json.contains("more") ? text_of(json["more"]) : std::string(); }

constexpr std::array step_names{"begins", "records", "pauses", "ends"};

StoreEvent event_of(const Json& json, double time) {
  return {time, json.value("kind", ""), json.value("who", ""), json.value("text", ""), more_of(json)};
}

JournalRow row_of(const Json& json, double time) {
  JournalRow row{.time = time};
  row.segment = json.value("segment", "");
  row.index = json.value("index", std::size_t{0});
  row.attempt = json.value("attempt", 1);
  row.run = json.value("run", 1);
  const std::string step = json.value("step", "begins");
  for (std::size_t i = 0; i < step_names.size(); ++i)
    if (step == step_names[i]) row.step = static_cast<JournalRow::Step>(i);
  row.finished = json.value("finished", false);
  row.reason = json.value("reason", "");
  row.json = more_of(json);
  return row;
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
  Json json{{"kind", event.kind}};
  if (!event.who.empty()) json["who"] = event.who;
  if (!event.text.empty()) json["text"] = event.text;
  if (!event.json.empty()) json["more"] = value_of(event.json);
  put_text(chunk, sequence, event.time, text_of(json));
}

void put_journal(Chunk& chunk, std::uint64_t sequence, const JournalRow& row) {
  Json json{{"segment", row.segment}, {"index", row.index}, {"attempt", row.attempt}, {"run", row.run}};
  json["step"] = step_names[static_cast<std::size_t>(row.step)];
  if (row.step == JournalRow::Step::ends) json["finished"] = row.finished;
  if (!row.reason.empty()) json["reason"] = row.reason;
  if (!row.json.empty()) json["more"] = value_of(row.json);
  put_text(chunk, sequence, row.time, text_of(json));
}

bool items_of_text(const Chunk& chunk, const std::function<void(const StoreItem&)>& visit) {
  const Json json = Json::parse(chunk.body, nullptr, false);
  if (!json.is_object()) return false;
  StoreItem item{.kind = chunk.kind, .sequence = chunk.first, .time = chunk.begin};
  try {
    const StoreEvent event = event_of(json, chunk.begin);
    const JournalRow row = row_of(json, chunk.begin);
    if (chunk.kind == StoreItem::Kind::event)
      item.event = &event;
    else
      item.journal = &row;
    visit(item);
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
  return text_of(json);
}

std::string json_of(const StoreStream& stream) {
  Json json{{"name", stream.name}, {"slot", stream.slot}, {"rate", stream.rate}};
  if (stream.link) json["link"] = *stream.link;
  json["channels"] = Json::array();
  for (const FrameChannel& channel : stream.channels)
    json["channels"].push_back(
        {{"name", channel.name}, {"unit", channel.unit.text()}, {"increment", channel.increment}});
  return text_of(json);
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

}  // namespace tumble::recorder
