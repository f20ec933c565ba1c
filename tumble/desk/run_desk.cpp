#include "tumble/desk/run_desk.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <deque>
#include <filesystem>
#include <mutex>
#include <thread>

#include "tumble/core/json_text.hpp"
#include "tumble/desk/desk_lines/curves.hpp"
#include "tumble/desk/desk_lines/run_json.hpp"
#include "tumble/recorder/quiet_thread.hpp"
#include "tumble/recorder/recorder_read.hpp"
#include "tumble/report/problem_json.hpp"
#include "tumble/station/typed_order.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace at_the_desk {  // named, since Inner has them as members

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;
using Code = boost::system::error_code;
using desk_lines::Json;
using What = decltype(RunEvent::what);

constexpr std::size_t most_unread = std::size_t{1} << 23;  ///< [byte] for one who does not read
constexpr std::size_t most_request = 1 << 16;              ///< [byte] of a line
constexpr std::size_t most_orders = 16;                    ///< that wait for the run
constexpr std::size_t most_events = 20000;                 ///< that are remembered

/// Somebody who is connected. Work under way holds it by a shared pointer.
struct Visitor {
  Local::socket socket;
  std::string input;
  std::deque<std::shared_ptr<const std::string>> output;
  std::size_t unread = 0;
  bool watches = false, leaves = false;

  explicit Visitor(Local::socket with) : socket(std::move(with)) {}
};
using SharedVisitor = std::shared_ptr<Visitor>;

void hang_up(Visitor& visitor) {
  Code ignored;
  visitor.socket.close(ignored);
}

void write_next(const SharedVisitor& visitor) {
  if (visitor->output.empty()) return visitor->leaves ? hang_up(*visitor) : void();
  const auto text = visitor->output.front();
  asio::async_write(visitor->socket, asio::buffer(*text), [visitor, text](Code code, std::size_t) {
    if (code) return hang_up(*visitor);
    visitor->unread -= text->size();
    visitor->output.pop_front();
    write_next(visitor);
  });
}

void say(const SharedVisitor& visitor, std::shared_ptr<const std::string> text) {
  visitor->unread += text->size();
  if (visitor->unread > most_unread && !visitor->output.empty()) return hang_up(*visitor);
  visitor->output.push_back(std::move(text));
  if (visitor->output.size() == 1) write_next(visitor);
}

void say(const SharedVisitor& visitor, std::string text) {
  say(visitor, std::make_shared<const std::string>(std::move(text)));
}

/// In English for other programs, and as values for those of ours.
std::string problem(const Problem& what) {
  const auto values = Json::parse(problems_to_json(code_of(Error::Kind::bad_input), {what}, Language::english));
  return json_text(Json{{"problem", what.text()}, {"problems", values}}) + "\n";
}

}  // namespace at_the_desk

using namespace at_the_desk;

/// What the thread of the run and that of the desk share stands behind the mutex; everything else belongs to the thread
/// of the desk.
struct RunDesk::Inner {
  asio::io_context context{1};
  Local::acceptor acceptor{context};
  asio::steady_timer patience{context};
  std::thread thread;
  std::string socket_path;
  int folder = -1;

  std::string facts;
  double speed = 1.0;
  std::deque<std::pair<std::uint64_t, std::string>> events;  ///< with their sequence numbers
  std::uint64_t last = 0;                                    ///< sequence number up to which all has been said
  std::optional<RunView> view;
  std::string ending;
  Sentence ending_text;
  desk_lines::Curves curves;
  desk_lines::EstimateHistory estimates;
  std::vector<SharedVisitor> visitors;

  std::mutex mutex;
  std::vector<What> orders;
  std::optional<Prompt> open_prompt;

  void accept();
  void read(const SharedVisitor& visitor);
  std::string answer(const SharedVisitor& visitor, const std::string& line);
  std::string take_order(const Json& request);
  std::string take_order(RunOrder::Kind kind, const std::string& who);
  std::string state() const;
  Json end_json() const;
  void tell(const std::string& name, std::uint64_t sequence, const std::string& json);
  void begin_watch(const SharedVisitor& visitor) const;
  void happened(std::uint64_t sequence, const Json& event);
  void show(const RunView& now);
  void leave();
  void wait_for_readers(std::chrono::steady_clock::time_point until);
};

void RunDesk::Inner::accept() {
  acceptor.async_accept([this](Code code, Local::socket socket) {
    if (code == asio::error::operation_aborted || !acceptor.is_open()) return;
    if (!code) {
      std::erase_if(visitors, [](const SharedVisitor& one) { return !one->socket.is_open(); });
      visitors.push_back(std::make_shared<Visitor>(std::move(socket)));
      read(visitors.back());
      return accept();
    }
    patience.expires_after(std::chrono::milliseconds(200));  // no descriptor is free: some will be soon
    patience.async_wait([this](Code stopped) {
      if (!stopped) accept();
    });
  });
}

void RunDesk::Inner::read(const SharedVisitor& visitor) {
  asio::async_read_until(visitor->socket, asio::dynamic_buffer(visitor->input, most_request), '\n',
                         [this, visitor](Code code, std::size_t size) {
                           if (code) return hang_up(*visitor);
                           const std::string line = visitor->input.substr(0, size);
                           visitor->input.erase(0, size);
                           if (auto text = answer(visitor, line); !text.empty()) say(visitor, std::move(text));
                           read(visitor);
                         });
}

std::string RunDesk::Inner::answer(const SharedVisitor& visitor, const std::string& line) {
  const Json request = Json::parse(line, nullptr, false);
  if (!request.is_object()) return problem("the request is not an object of JSON");
  try {
    if (request.contains("order")) return take_order(request);
    const auto asked = request.value("ask", "");
    if (asked == "state") return state() + "\n";
    if (asked == "watch") return begin_watch(visitor), std::string();
  } catch (const Json::exception&) {
  }
  return problem("the request is not known: an ask or an order is expected");
}

/// However many come, the run has time for its rig, and an order to end it is never refused.
std::string RunDesk::Inner::take_order(RunOrder::Kind kind, const std::string& who) {
  const auto is_same = [&](const What& one) {
    const auto* const order = std::get_if<RunOrder>(&one);
    return order && order->kind == kind;
  };
  const bool ends = kind == RunOrder::Kind::stop || kind == RunOrder::Kind::abort;
  if (!ends && orders.size() >= most_orders) return problem("too many orders wait: the run takes the next one later");
  if (!ends || std::ranges::none_of(orders, is_same)) orders.push_back(RunOrder{kind, who});
  return "{\"taken\":true}\n";
}

std::string RunDesk::Inner::take_order(const Json& request) {
  const auto order = request.value("order", ""), who = request.value("who", "");
  if (who.empty() || who.size() > 200) return problem("an order needs a name: who gives it");
  if (!ending.empty()) return problem("the run has ended");
  const std::lock_guard lock(mutex);
  if (const auto kind = find_order(order)) return take_order(*kind, who);
  if (order != "answer") return problem(say("'{}' is no order (orders: pause, resume, stop, abort, answer)", order));
  const int number = request.value("prompt", 0);
  const auto choice = request.value("choice", "");
  if (!open_prompt || open_prompt->id != number) return problem(say("question {} is closed", number));
  if (std::ranges::find(open_prompt->choices, choice) == open_prompt->choices.end()) {
    std::string choices;
    for (const auto& one : open_prompt->choices) choices += (choices.empty() ? "" : ", ") + one;
    return problem(say("'{}' is no answer to question {} (answers: {})", choice, number, Name{choices}));
  }
  orders.push_back(PromptAnswer{number, choice, who});
  open_prompt.reset();
  return "{\"taken\":true}\n";
}

std::string RunDesk::Inner::state() const {
  Json list = Json::array();
  std::string all;
  for (const auto& [sequence, json] : events) all += (all.empty() ? "" : ",") + json;
  const std::string values = sentence_to_json(ending_text);
  const std::string said = values.empty() ? "" : "\"ending_text_said\":" + values + ",";
  return fmt::format(R"({{"alive":true,"last":{},"ending":{},"ending_text":{},{}"facts":{},"view":{},"curves":{},)"
                     R"("estimates":{},"events":[{}]}})",
                     last, Json(ending).dump(), json_text(Json(ending_text.text())), said, facts,
                     view ? json_text(desk_lines::json_of(*view, speed)) : "null",
                     json_text(desk_lines::json_of(curves)), json_text(desk_lines::json_of(estimates)), all);
}

Json RunDesk::Inner::end_json() const {
  Json json{{"ending", ending}};
  desk_lines::put_said(json, "text", ending_text);
  return json;
}

/// "view 1234 {...}" to all who watch.
void RunDesk::Inner::tell(const std::string& name, std::uint64_t sequence, const std::string& json) {
  const auto line = std::make_shared<const std::string>(fmt::format("{} {} {}\n", name, sequence, json));
  for (const auto& visitor : visitors)
    if (visitor->watches && visitor->socket.is_open()) say(visitor, line);
}

void RunDesk::Inner::begin_watch(const SharedVisitor& visitor) const {
  std::string lines;
  for (const auto& [sequence, json] : events)
    if (sequence > 0) lines += fmt::format("happened {} {}\n", sequence, json);
  if (view) lines += fmt::format("view {} {}\n", last, json_text(desk_lines::json_of(*view, speed)));
  lines += fmt::format("now {} {{}}\n", last);  // what comes is new
  visitor->watches = true;
  say(visitor, std::move(lines));
}

void RunDesk::Inner::happened(std::uint64_t sequence, const Json& event) {
  last = std::max(last, sequence);
  const auto json = json_text(event);
  events.emplace_back(sequence, json);
  if (events.size() > most_events) events.pop_front();
  tell("happened", sequence > 0 ? sequence : last, json);
}

void RunDesk::Inner::show(const RunView& now) {
  last = std::max(last, now.sequence);
  curves.add(now);
  estimates.add(now);
  view = now;
  if (std::ranges::any_of(visitors, &Visitor::watches)) tell("view", last, json_text(desk_lines::json_of(now, speed)));
}

/// Everybody is told; who does not take it within a second misses it.
void RunDesk::Inner::leave() {
  Code ignored;
  acceptor.close(ignored);
  tell("end", last, json_text(end_json()));
  for (const auto& visitor : visitors) {
    visitor->leaves = true;
    if (visitor->output.empty()) hang_up(*visitor);
  }
  wait_for_readers(std::chrono::steady_clock::now() + std::chrono::seconds(1));
}

void RunDesk::Inner::wait_for_readers(std::chrono::steady_clock::time_point until) {
  const bool all_have_left = std::ranges::none_of(visitors, [](const auto& one) { return one->socket.is_open(); });
  if (all_have_left || std::chrono::steady_clock::now() > until) return context.stop();
  patience.expires_after(std::chrono::milliseconds(5));
  patience.async_wait([this, until](Code code) {
    if (!code) wait_for_readers(until);
  });
}

RunDesk::RunDesk() : inner_(std::make_unique<Inner>()) {}

RunDesk::~RunDesk() {
  if (inner_->thread.joinable()) {
    asio::post(inner_->context, [this] { inner_->leave(); });
    inner_->thread.join();
    ::unlink(inner_->socket_path.c_str());
  }
  if (inner_->folder >= 0) ::close(inner_->folder);
}

void RunDesk::open(const std::string& folder, const RunFacts& facts, double speed) {
  Inner& inner = *inner_;
  inner.facts = json_text(desk_lines::json_of(facts));
  inner.speed = speed;
  inner.socket_path = (std::filesystem::path(folder) / desk_name).string();
  ::unlink(inner.socket_path.c_str());  // of a process that was killed: the store says that there is no other
  inner.folder = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  // A name of a socket has 107 bytes at most; this one leads to the folder however long its name is.
  const Local::endpoint place(fmt::format("/proc/self/fd/{}/{}", inner.folder, desk_name));
  Code code;
  inner.acceptor.open(place.protocol(), code);
  if (!code) fchmod(inner.acceptor.native_handle(), S_IRUSR | S_IWUSR);
  if (!code) inner.acceptor.bind(place, code);
  if (!code) inner.acceptor.listen(64, code);
  if (code)
    throw Error(Error::Kind::bad_file,
                say("the run cannot be watched from elsewhere: {}: {}", Name{inner.socket_path}, system_reason(code)));
  inner.accept();
  inner.thread = quiet_thread([&inner] { inner.context.run(); });
}

void RunDesk::remember(std::uint64_t sequence, const StoreEvent& event) {
  asio::post(inner_->context,
             [this, sequence, event] { inner_->happened(sequence, desk_lines::json_of(sequence, event)); });
}

void RunDesk::remember(std::uint64_t sequence, double time, const RunRow& row) {
  asio::post(inner_->context,
             [this, sequence, time, row] { inner_->happened(sequence, desk_lines::json_of(sequence, time, row)); });
}

void RunDesk::ended(const RunEnd& end) {
  asio::post(inner_->context, [this, end] {
    inner_->ending = name(end.ending);
    inner_->ending_text = end.text;
    inner_->tell("ended", inner_->last, json_text(inner_->end_json()));
  });
}

RunCompany RunDesk::beside(RunCompany company) {
  RunCompany both = company;
  both.orders = [this, other = std::move(company.orders)] {
    auto orders = other ? other() : std::vector<What>{};
    const std::lock_guard lock(inner_->mutex);
    for (auto& order : inner_->orders) orders.push_back(std::move(order));
    inner_->orders.clear();
    return orders;
  };
  both.ask = [this, other = std::move(company.ask)](const Prompt& prompt) {
    {
      const std::lock_guard lock(inner_->mutex);
      inner_->open_prompt = prompt;
    }
    if (other) other(prompt);
  };
  both.event = [this, other = std::move(company.event)](std::uint64_t sequence, const StoreEvent& event) {
    remember(sequence, event);
    if (other) other(sequence, event);
  };
  both.row = [this, other = std::move(company.row)](std::uint64_t sequence, double time, const RunRow& row) {
    remember(sequence, time, row);
    if (other) other(sequence, time, row);
  };
  both.show = [this, other = std::move(company.show)](const RunView& view) {
    if (!view.prompt) {
      const std::lock_guard lock(inner_->mutex);
      inner_->open_prompt.reset();
    }
    asio::post(inner_->context, [this, view] { inner_->show(view); });
    if (other) other(view);
  };
  return both;
}

void remember_run(RunDesk& desk, const std::string& folder) {
  visit_events(folder, [&](const StoreItem& item) {
    if (!desk_lines::is_shown(item)) return;
    if (item.event) desk.remember(item.sequence, *item.event);
    if (item.journal) desk.remember(item.sequence, item.time, *item.journal);
  });
}

RunCompany at_desk(RunDesk& desk, const std::string& folder, const RunFacts& facts, double speed,
                   const RunCompany& company) {
  try {
    desk.open(folder, facts, speed);
    return desk.beside(company);
  } catch (const Error& error) {
    if (company.note) company.note({EventKind::desk, reason_of(error)}, 0.0);
    return company;
  }
}

}  // namespace tumble
