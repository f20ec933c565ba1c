#include "tumble/pyramid/store/store.hpp"

namespace tumble::store {

Json description_of(const Recording& recording) {
  Json channels = Json::array(), marks = Json::array();
  for (const Channel& channel : recording.channels)
    channels.push_back({{"name", channel.name},
                        {"kind", static_cast<int>(channel.kind)},
                        {"unit", channel.unit.text()},
                        {"stamped", !channel.timeline.uniform()},
                        {"start", channel.timeline.start},
                        {"rate", channel.timeline.rate}});
  for (const Mark& mark : recording.marks) {
    Json entry{{"label", mark.label}, {"begin", mark.begin}, {"run", mark.run}};
    if (mark.end < std::numeric_limits<double>::infinity()) entry["end"] = mark.end;
    marks.push_back(entry);
  }
  return {{"instrument", recording.instrument}, {"channels", channels}, {"marks", marks}, {"meta", recording.meta}};
}

Recording recording_of(const Json& description) {
  Recording recording;
  recording.instrument = description.at("instrument").get<std::string>();
  for (const Json& entry : description.at("channels")) {
    Channel channel{entry.at("name").get<std::string>(),
                    static_cast<QuantityKind>(entry.at("kind").get<int>()),
                    Unit::parse(entry.at("unit").get<std::string>()),
                    {},
                    {}};
    channel.timeline = {entry.at("start").get<double>(), entry.at("rate").get<double>(), nullptr};
    recording.channels.push_back(std::move(channel));
  }
  for (const Json& entry : description.at("marks")) {
    Mark mark{entry.at("label").get<std::string>(), entry.at("begin").get<double>(), entry.at("run").get<int>()};
    if (entry.contains("end")) mark.end = entry.at("end").get<double>();
    recording.marks.push_back(mark);
  }
  recording.meta = description.at("meta").get<std::map<std::string, std::string>>();
  return recording;
}

}  // namespace tumble::store
