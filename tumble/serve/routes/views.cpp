#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tumble/serve/routes/answers.hpp"
#include "tumble/serve/routes/numbers.hpp"
#include "tumble/serve/routes/plan_files.hpp"
#include "tumble/serve/routes/query.hpp"
#include "tumble/serve/routes/routes.hpp"
#include "tumble/units/error.hpp"

namespace tumble::routes {
namespace {

/// Channels of a prepared recording, each in a unit, over a span.
struct Wanted {
  std::shared_ptr<const PreparedRecording> prepared;
  struct Row {
    std::size_t channel;
    Unit unit;
  };
  std::vector<Row> rows;
  double from = 0.0, to = 0.0;  ///< [s]

  const Pyramid& pyramid() const { return *prepared->pyramid; }
};

std::shared_ptr<const PreparedRecording> prepared(Context& context, const HttpRequest& request) {
  const auto path = existing(context, required(request, "file"));
  const auto state = context.recordings.find(path, sets_of(all_of(request, "set")), true, user_of(context, request));
  if (state.prepared) return state.prepared;
  if (!state.problems.empty()) throw Error{Error::Kind::bad_file, state.problems};
  throw Error{Error::Kind::bad_data, "the recording is being prepared"};
}

/// channel=NAME&unit=UNIT, as often as wanted; without any all channels in their own units.
void take_rows(const HttpRequest& request, Wanted& wanted) {
  const auto& channels = wanted.pyramid().channels();
  const auto names = all_of(request, "channel"), units = all_of(request, "unit");
  if (!units.empty() && units.size() != names.size())
    throw Error{Error::Kind::bad_input, "there must be one unit for each channel, or none"};
  Problems problems;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::ranges::find(channels, names[i], &PyramidChannel::name);
    if (found == channels.end()) {
      problems.push_back(say("there is no channel '{}'", names[i]));
      continue;
    }
    const Unit unit = units.empty() || units[i].empty() ? found->unit : Unit::parse(units[i]);
    if (unit.dimension() != found->unit.dimension())
      problems.push_back(say("channel '{}' is in {}, which is not a kind of {}", names[i], Name{found->unit.text()},
                             Name{unit.text()}));
    wanted.rows.push_back({static_cast<std::size_t>(found - channels.begin()), unit});
  }
  if (!problems.empty()) throw Error{Error::Kind::bad_input, problems};
  for (std::size_t i = 0; names.empty() && i < channels.size(); ++i) wanted.rows.push_back({i, channels[i].unit});
}

Wanted wanted_by(Context& context, const HttpRequest& request) {
  Wanted wanted{prepared(context, request), {}, required_number(request, "from"), required_number(request, "to")};
  if (!(wanted.to >= wanted.from)) throw Error{Error::Kind::bad_input, "the span ends before it begins"};
  take_rows(request, wanted);
  return wanted;
}

template <class Number>
void put(std::string& bytes, const Number* numbers, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(numbers), count * sizeof(Number));
  bytes.resize((bytes.size() + 7) / 8 * 8, '\0');
}

/// docs/workbench.md describes the bytes. Little-endian, as the computers are for which Tumble is built.
void put(std::string& bytes, const ChannelView& view) {
  const std::size_t count = view.samples ? view.values.size() : view.low.size();
  const double head[] = {view.samples ? 1.0 : 0.0,
                         static_cast<double>(count),
                         static_cast<double>(view.first),
                         static_cast<double>(view.block),
                         view.offset,
                         view.start,
                         view.step};
  put(bytes, head, std::size(head));
  if (view.step == 0.0) put(bytes, view.times.data(), count);
  if (view.samples) return put(bytes, view.values.data(), count);
  put(bytes, view.low.data(), count);
  put(bytes, view.high.data(), count);
  put(bytes, view.flags.data(), count);
}

HttpResponse view(Context& context, const HttpRequest& request) {
  const Wanted wanted = wanted_by(context, request);
  const double pixels = required_number(request, "pixels");
  if (!(pixels >= 1.0 && pixels <= 8192.0)) throw Error{Error::Kind::bad_input, "pixels: 1 to 8192 are expected"};
  HttpResponse response;
  response.type = "application/octet-stream";
  const double head[] = {static_cast<double>(wanted.rows.size())};
  put(response.body, head, 1);
  for (const auto& row : wanted.rows)
    put(response.body,
        wanted.pyramid().view(row.channel, wanted.from, wanted.to, static_cast<std::size_t>(pixels), row.unit));
  // The address says all that the answer depends on, where it says the tag: it may be kept.
  if (find_query(request, "tag") && !wanted.prepared->live)
    response.headers.emplace_back("Cache-Control", "private, max-age=3600");
  return response;
}

HttpResponse statistics(Context& context, const HttpRequest& request) {
  const Wanted wanted = wanted_by(context, request);
  Json rows = Json::array();
  for (const auto& [channel, unit] : wanted.rows) {
    const Pyramid& pyramid = wanted.pyramid();
    const std::size_t first = pyramid.index_at(channel, wanted.from);
    const std::size_t end =
        pyramid.index_at(channel, std::nextafter(wanted.to, std::numeric_limits<double>::infinity()));
    const SpanStatistics of = pyramid.statistics(channel, first, end);
    const double sd = unit.difference_from_si(of.sd), slope = unit.difference_from_si(of.slope);
    const double scale = sd > 0.0 ? sd : 0.0;
    const auto text = [&](double value_si) { return number_text(unit.from_si(value_si), scale); };
    const bool any = of.samples > of.missing;
    rows.push_back({{"channel", pyramid.channels()[channel].name},
                    {"unit", unit.text()},
                    {"samples", of.samples},
                    {"missing", of.missing},
                    {"first", of.first},
                    {"last", of.last},
                    {"mean", number(of.mean, unit)},
                    {"sd", std::isfinite(sd) ? Json(sd) : Json()},
                    {"minimum", number(of.minimum, unit)},
                    {"maximum", number(of.maximum, unit)},
                    {"slope", std::isfinite(slope) ? Json(slope) : Json()},
                    {"slope_unit", unit.text() == "1" ? "1/s" : "(" + unit.text() + ")/s"},
                    {"text",
                     {{"mean", any ? text(of.mean) : ""},
                      {"sd", std::isfinite(sd) ? fmt::format("{:.4g}", sd) : ""},
                      {"minimum", any ? text(of.minimum) : ""},
                      {"maximum", any ? text(of.maximum) : ""},
                      {"slope", std::isfinite(slope) ? fmt::format("{:.4g}", slope) : ""}}}});
  }
  return json_response({{"from", wanted.from}, {"to", wanted.to}, {"rows", rows}});
}

/// The sample nearest to a time.
std::size_t nearest_sample(const Pyramid& pyramid, std::size_t channel, double time) {
  const std::size_t after = pyramid.index_at(channel, time), count = pyramid.channels()[channel].samples;
  if (after == 0) return 0;
  if (after == count) return count - 1;
  return time - pyramid.time(channel, after - 1) < pyramid.time(channel, after) - time ? after - 1 : after;
}

/// Values at one or two times: at=A&at=B.
HttpResponse values(Context& context, const HttpRequest& request) {
  Wanted wanted{prepared(context, request), {}, 0.0, 0.0};
  take_rows(request, wanted);
  std::vector<double> times;
  for (const auto& text : all_of(request, "at")) {
    HttpRequest one;
    one.query = {{"at", text}};
    times.push_back(required_number(one, "at"));
  }
  if (times.empty() || times.size() > 2) throw Error{Error::Kind::bad_input, "at: one or two times are expected"};
  Json rows = Json::array();
  for (const auto& [channel, unit] : wanted.rows) {
    const Pyramid& pyramid = wanted.pyramid();
    if (pyramid.channels()[channel].samples == 0) continue;
    Json row{{"channel", pyramid.channels()[channel].name}, {"unit", unit.text()}, {"values", Json::array()}};
    std::vector<double> found, at;
    for (const double time : times) {
      const std::size_t sample = nearest_sample(pyramid, channel, time);
      pyramid.read(channel, sample, 1, found);
      at.push_back(pyramid.time(channel, sample));
      row["values"].push_back(
          {{"time", at.back()},
           {"value", number(found.back(), unit)},
           {"text", std::isfinite(found.back()) ? fmt::format("{:.9g}", unit.from_si(found.back())) : ""}});
    }
    if (found.size() == 2) {
      const double difference = unit.difference_from_si(found[1] - found[0]);
      row["difference"] = std::isfinite(difference) ? Json(difference) : Json();
      row["difference_text"] = std::isfinite(difference) ? fmt::format("{:.6g}", difference) : "";
      row["time_difference"] = at[1] - at[0];
    }
    rows.push_back(row);
  }
  return json_response({{"rows", rows}});
}

/// Samples of one channel in order, read in pieces.
struct Reading {
  std::size_t channel = 0, next = 0, end = 0, begin = 0;  ///< `values` begin at sample `begin`
  Unit unit;
  std::vector<double> values;

  bool ended() const { return next == end; }
  double time(const Pyramid& pyramid) const { return pyramid.time(channel, next); }
  double take(const Pyramid& pyramid) {
    constexpr std::size_t piece = 1 << 15;
    if (next - begin >= values.size()) {
      begin = next;
      values.clear();
      pyramid.read(channel, begin, std::min(piece, end - begin), values);
    }
    return values[next++ - begin];
  }
};

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? "\"\"" : std::string(1, letter);
  return quoted + "\"";
}

/// A row for each time at which any channel has a sample; the cells of the others are blank.
class Table {
 public:
  explicit Table(Wanted wanted) : wanted_(std::move(wanted)) {
    for (const auto& [channel, unit] : wanted_.rows) {
      Reading reading;
      reading.channel = channel;
      reading.unit = unit;
      reading.next = reading.begin = wanted_.pyramid().index_at(channel, wanted_.from);
      reading.end =
          wanted_.pyramid().index_at(channel, std::nextafter(wanted_.to, std::numeric_limits<double>::infinity()));
      readings_.push_back(reading);
    }
  }

  std::string head() const {
    std::string text = "time[s]";
    for (const auto& [channel, unit] : wanted_.rows)
      text += "," + csv_cell(wanted_.pyramid().channels()[channel].name + "[" + unit.text() + "]");
    return text + "\n";
  }

  /// False: there is no more.
  bool append(std::string& text) {
    constexpr std::size_t enough = 1 << 18;
    const Pyramid& pyramid = wanted_.pyramid();
    while (text.size() < enough) {
      double time = std::numeric_limits<double>::infinity();
      for (const Reading& reading : readings_)
        if (!reading.ended()) time = std::min(time, reading.time(pyramid));
      if (std::isinf(time)) return !text.empty();
      fmt::format_to(std::back_inserter(text), "{}", time);
      for (Reading& reading : readings_) {
        text += ',';
        if (reading.ended() || reading.time(pyramid) != time) continue;
        const double value = reading.take(pyramid);
        if (!std::isnan(value)) text += format_in(value, reading.unit);
      }
      text += '\n';
    }
    return true;
  }

 private:
  Wanted wanted_;
  std::vector<Reading> readings_;
};

HttpResponse csv(Context& context, const HttpRequest& request) {
  auto table = std::make_shared<Table>(wanted_by(context, request));
  HttpResponse response;
  response.type = "text/csv; charset=utf-8";
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"span.csv\"");
  auto begun = std::make_shared<bool>(false);
  response.more = [table, begun](std::string& text) {
    if (!*begun) {
      *begun = true;
      text += table->head();
      table->append(text);
      return true;
    }
    return table->append(text);
  };
  return response;
}

}  // namespace

std::vector<Route> view_routes() {
  return {{"GET", "/api/recording/view", view},
          {"GET", "/api/recording/statistics", statistics},
          {"GET", "/api/recording/values", values},
          {"GET", "/api/recording/csv", csv}};
}

}  // namespace tumble::routes
