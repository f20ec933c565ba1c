#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tumble/units/sentence.hpp"
#include "tumble/units/unit.hpp"
#include "tumble/wire/controller_verb.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble {

/// A request of a station to a rig, a chamber or a supply. Values are SI: {"position", rad}. `position.2` is the
/// position of axis 2 in a command that carries several axes; `position` is that of `axis`.
struct ControllerRequest {
  ControllerVerb verb{};
  std::map<std::string, double> values = {};
  int axis = 1;
};

/// A reply of a controller. Only a reply without `problem` and without `refused` carries values.
struct ControllerReply {
  ControllerVerb verb{};                          ///< of the request, or `notice`
  std::map<std::string, double> values = {};      ///< [SI]
  std::map<std::string, std::string> words = {};  ///< {"state", "moving"}
  bool refused = false;   ///< the controller understood and said no, or reads back another value
  Sentence text = {};     ///< why; of a notice, the text. What the device says is a name in it
  Sentence problem = {};  ///< not empty: bytes that are no answer; the request stays outstanding
  int axis = 1;
};

/// A piece of a template: fixed bytes, or a field in braces.
struct ControllerPiece {
  enum class Kind { literal, any, word, number, axis };
  enum class Part { whole, sign, magnitude };
  Kind kind = Kind::literal;
  std::string text;         ///< the bytes of a literal, the name of a field
  int axis = 0;             ///< of {position.2}; 0: the axis of the request
  Part part = Part::whole;  ///< of a number: {rate!sign}{rate!abs:.3f deg/s}
  /// Binary, or decimal (real or integer) or hexadecimal digits; a word is a text of format.width characters, 0: open.
  FrameNumber number = {.kind = FrameNumber::Kind::real, .bytes = 8, .bits = 64, .form = FrameNumber::Form::decimal};
  FrameFormat format = {.zeros = false};
  Unit unit = {};                             ///< in which the device speaks
  double factor = 1.0;                        ///< [unit] of one step of a number
  std::optional<std::string> otherwise = {};  ///< what is written where no value is given
};

/// Bytes with fields, for both directions: filled by the one who speaks, compared by the one who listens.
struct ControllerTemplate {
  std::string source;  ///< as the declaration has it
  std::vector<ControllerPiece> pieces;
};

/// Access to a register of Modbus.
struct ControllerRegister {
  int address = 0;         ///< of axis 1, from 0
  int step = 0;            ///< from axis to axis
  int function = 3;        ///< 3, 6 or 16
  ControllerPiece number;  ///< name, type, order of bytes, unit, factor
  bool low_word_first = false;
  std::optional<double> constant = {};  ///< [steps] what is written where it is no value of the request
};

/// One question and its answer.
struct ControllerExchange {
  ControllerTemplate send;
  std::vector<ControllerTemplate> expect;         ///< the device writes the first; empty: there is no reply
  std::vector<ControllerTemplate> refused;        ///< replies that say no to this exchange
  std::optional<ControllerRegister> modbus = {};  ///< in place of the templates
  std::vector<std::string> json = {};             ///< HTTP: pointers to the words of a reply
  bool bare = false;                              ///< sent without head, tail and checksum
  std::map<std::string, double> set = {};         ///< values without unit that this exchange gives by itself
  std::string when = {};                          ///< sent only if the request has this value
  double timeout = 1.0;                           ///< [s]
  double pause = 0.0;                             ///< [s] that the line is quiet before
};

/// A verb as this controller carries it out.
struct ControllerCommand {
  ControllerVerb verb{};
  std::vector<ControllerExchange> exchanges;
  bool once = false;                             ///< must never be sent again when its fate is unknown
  std::optional<ControllerVerb> read_back = {};  ///< the verb that reads what this one set
  std::optional<ControllerVerb> same_as = {};    ///< the verb that sends the same bytes, which the device side reports
  FrameCertainty certainty = FrameCertainty::uncertain;
  std::string note;
  std::vector<std::string> takes;      ///< names of values that a request may carry
  std::vector<std::string> requires_;  ///< those without which it is refused
  std::vector<std::string> gives;      ///< names of values and words of its reply
};

/// A rule that makes a word of a whole number: (number & mask) == equals.
struct ControllerBitRule {
  std::uint32_t mask = 0, equals = 0;
  std::string means;
};

/// A word made of the bits of a number that replies carry; the first rule that holds counts.
struct ControllerBits {
  std::string word, from;
  std::vector<ControllerBitRule> rules;
};

/// Texts of the device and the words that they mean, in the order of the declaration.
using ControllerWords = std::vector<std::pair<std::string, std::string>>;

/// A text by which the device refuses any command, or speaks without being asked.
struct ControllerSaying {
  ControllerTemplate expect;
  std::map<std::string, std::string> meaning;  ///< by the text of its first word
  std::string state;                           ///< of a notice: the word "state" that it gives
};

/// How bodies become bytes on the line, in one direction.
struct ControllerFraming {
  std::string head;
  std::vector<std::string>
      tail;  ///< the first is written, each is accepted; empty: the length follows from the template
};

/// The checksum behind a body.
struct ControllerChecksum {
  /// Hexadecimal digits; bytes, the lowest first; one byte whose bit 7 is set.
  enum class Form { digits, bytes, bit7 };
  std::optional<FrameChecksum> sum = {};  ///< `before` stands between body and checksum; absent: no checksum
  Form form = Form::bytes;
  bool with_head = false;  ///< the head is part of what is summed
};

/// Settings of messages of HTTP beside the command.
struct ControllerHttp {
  std::string host = "localhost";
  std::vector<std::string> headers = {};  ///< of requests, "Authorization: Bearer abc"
  std::string message = {};               ///< JSON pointer to the text of an error
};

/// The line that the controller listens on.
struct ControllerLink {
  int tcp = 0;          ///< port; 0: none
  long baud = 0;        ///< of a serial line; 0: none
  std::string format;   ///< "8N1"
  std::string flow;     ///< "xonxoff", or empty
  double period = 0.1;  ///< [s] that it can be polled with
};

/// An exchange that the declaration is tested with, in both directions.
struct ControllerVector {
  ControllerRequest request;
  std::vector<std::string> sends, replies;  ///< bytes, with everything around them, of each exchange
  ControllerReply reply;                    ///< [SI]
  std::map<std::string, double> tolerance;  ///< [SI] half a unit of the last digit written
  bool host_only = false;                   ///< the device side writes it in another form
  std::string source;
  bool made_by_hand = false;
  Where place;  ///< file and line
};

/// A declaration of a controller, read and checked (docs/formats/controllers.md has its keys).
struct Controller {
  std::string name, title, source, note;
  FrameCertainty certainty = FrameCertainty::uncertain;
  enum class Protocol { text, modbus_tcp, modbus_rtu, http } protocol = Protocol::text;
  ControllerLink link;
  std::vector<std::string> axes;  ///< as the device names them, "1" or "X"
  std::map<std::string, std::string> settings;
  ControllerFraming send, reply;
  ControllerChecksum checksum;
  bool bit7 = false;  ///< all bytes of a body have bit 7 set on the line
  bool trim = true;   ///< spaces around a body have no meaning
  enum class Echo { never, maybe, always } echo = Echo::never;
  int skip = 0;                ///< bytes before each reply that have no meaning
  std::size_t longest = 1024;  ///< [byte] of a reply
  int unit = 1;                ///< Modbus: the address of the device
  ControllerHttp http;
  std::string lost_link;  ///< what the rig does by itself when the host is silent; empty: nothing is known
  std::vector<ControllerCommand> commands;
  std::vector<ControllerSaying> errors, notices;
  std::map<std::string, ControllerWords> words;
  std::vector<ControllerBits> bits;
  std::vector<ControllerVector> vectors;

  /// Null where the controller cannot do it.
  const ControllerCommand* find(ControllerVerb verb) const;
  bool is_modbus() const { return protocol == Protocol::modbus_tcp || protocol == Protocol::modbus_rtu; }
  /// A maker's or two independent sources say it; the others are examples.
  bool supported() const { return certainty == FrameCertainty::maker || certainty == FrameCertainty::crossed; }
};

/// Reads a declaration.
///
/// Given     toml       its text
///           file       its name, for messages
///           settings   of the declaration in place of their defaults, by name
///
/// Returned  the controller, of which every test vector holds in both directions; with settings that differ from the
///           defaults it has no vectors, because these are bytes for the defaults
///
/// Throws    Error::bad_input with all problems, each with its line
Controller read_controller(std::string_view toml, const std::string& file,
                           const std::map<std::string, std::string>& settings = {});

/// Problems of the test vectors, as host and as device; empty: all hold.
Problems problems_of_vectors(const Controller& controller);

/// [SI] by how much a value may change on its way through the template of this verb: half a step of its format.
double resolution_of(const Controller& controller, ControllerVerb verb, const std::string& value, double si);

/// The side of the station. Pure: the caller sends bytes, keeps the clock, and says when a reply is overdue.
///
///     send(host.ask(request));
///     for (;;) {
///       for (const auto& reply : host.feed(received)) ...   // also with no bytes, once after each send
///       if (const auto more = host.next(); !more.empty()) wait(host.pause()), send(more);
///       if (host.waiting() && waited > host.timeout()) host.give_up();
///     }
class ControllerHost {
 public:
  explicit ControllerHost(const Controller& controller);  ///< which must live as long

  /// Begins a request. Returned: the bytes to send first.
  /// Throws Error::bad_input: another request is outstanding, a value is missing or does not fit the format, there is
  /// no such axis; Error::unsupported: the controller has no such verb.
  std::string ask(const ControllerRequest& request);

  /// Replies that these bytes complete, and what is wrong with others. An empty `bytes` gives the reply of a command
  /// that the controller does not answer.
  std::vector<ControllerReply> feed(std::string_view bytes);

  /// Bytes of the next exchange of the verb, to be sent pause() seconds after the last byte; empty: none is due.
  std::string next();

  bool idle() const { return !command_; }               ///< a request may be asked
  bool waiting() const { return command_ && awaits_; }  ///< for a reply
  double timeout() const;                               ///< [s] from sending, for the reply that is awaited
  double pause() const;  ///< [s] of quiet that the controller wants before the next bytes
  const ControllerRequest& request() const { return request_; }

  /// Forgets the request that is outstanding. Returned: a reply whose problem says what was missing. Its reply may come
  /// late. Before the next reading is asked for, a question whose answer is of another form is sent: what comes before
  /// that answer is late, and is no reading of another axis. Where the declaration has no such question, nothing is
  /// sent until the late reply has come, or the caller says that the line is clear.
  ControllerReply give_up();
  bool waits_for_quiet() const { return quiet_; }
  /// No late reply can come any more: the link is new, or was quiet for long enough.
  void line_is_clear();

 private:
  struct Owed {
    const ControllerExchange* exchange = nullptr;
    std::string sent;
  };
  const ControllerExchange& exchange() const { return command_->exchanges[exchange_]; }
  const ControllerExchange* awaited() const { return probe_ ? probe_ : waiting() && !quiet_ ? &exchange() : nullptr; }
  void owe(const ControllerExchange& late);
  std::optional<std::size_t> late_match(std::string_view body) const;
  bool drop_late(std::string_view body);
  bool is_reading() const;
  bool must_clear() const;
  const ControllerExchange* question_to_clear() const;
  std::string ask_to_clear();
  void take_while_unclear(const std::string& body, std::vector<ControllerReply>& replies);
  std::string send();
  void advance(std::vector<ControllerReply>& replies);
  void take_body(std::string body, std::vector<ControllerReply>& replies);
  void accept(const ControllerReply& part, std::vector<ControllerReply>& replies);
  void end(ControllerReply reply, std::vector<ControllerReply>& replies);
  ControllerReply problem(const Sentence& what) const;
  std::map<std::string, double> values_to_send(const ControllerExchange& exchange) const;
  void remember();
  void forget_motions();

  const Controller* controller_;
  ControllerRequest request_;
  const ControllerCommand* command_ = nullptr;  ///< outstanding
  std::size_t exchange_ = 0;
  bool awaits_ = false, due_ = false;
  ControllerReply reply_;               ///< collected over the exchanges
  std::vector<ControllerReply> ready_;  ///< to hand out with the next feed
  std::string pending_, sent_;
  std::map<std::string, double> last_;  ///< [SI] values by axis that were sent last
  std::uint16_t transaction_ = 0;       ///< of Modbus over TCP
  std::vector<Owed> owed_;              ///< of requests that were given up, in order: their replies may come late
  const ControllerExchange* probe_ = nullptr;  ///< question whose answer shows that no late reply follows; null: none
  bool spoiled_ = false;                       ///< something came in place of the reply
  bool quiet_ = false;                         ///< the request is sent when the line is clear
};

/// The side of the controller: for the virtual rig, and for the test that a declaration works in both directions.
///
///     for (const auto& request : device.feed(received)) device.answer(reply_to(request));
///     send(device.output());
class ControllerDevice {
 public:
  explicit ControllerDevice(const Controller& controller);  ///< which must live as long

  /// Requests that these bytes complete, in order. Each wants one answer. Where a verb takes several exchanges, the
  /// request comes with the last of them, and with each whose reply carries a value.
  std::vector<ControllerRequest> feed(std::string_view bytes);

  /// Answers the oldest request without an answer.
  /// Throws Error::bad_input where a value or a word is missing that the reply carries, or does not fit.
  void answer(const ControllerReply& reply);

  /// Says the notice that gives this state, without being asked. Throws Error::bad_input where no notice does.
  void notice(const std::string& state);

  /// Bytes that are ready to be sent: answers, and replies that need no answer, in order.
  std::string output();

  /// Problems of the bytes since the last call: checksums, unknown commands.
  Problems problems();

 private:
  struct Slot {
    bool answered = false;
    std::string bytes;  ///< that are ready
    const ControllerCommand* command = nullptr;
    std::size_t exchange = 0;
    ControllerRequest request;
    std::string sent;  ///< body, for an echo
    std::uint16_t transaction = 0;
  };
  struct Progress {
    std::size_t next = 0;    ///< exchange that is expected
    std::uint64_t when = 0;  ///< number of the line that led here
    ControllerRequest request;
  };
  struct Match {
    std::size_t command = 0, exchange = 0;
    ControllerRequest request;
  };

  bool take_bare(std::vector<ControllerRequest>& requests);
  void take_body(const std::string& body, bool bare, std::uint16_t transaction,
                 std::vector<ControllerRequest>& requests);
  std::vector<Match> matches_of(const std::string& body, bool bare) const;
  void proceed(const std::vector<Match>& matches, Slot slot, std::vector<ControllerRequest>& requests);
  std::string reply_bytes(const Slot& slot, const ControllerReply& reply) const;
  std::string error_bytes(const Slot& slot, const std::string& text) const;

  const Controller* controller_;
  std::string pending_;
  std::deque<Slot> slots_;
  std::vector<Progress> progress_;  ///< by command
  std::uint64_t lines_ = 0;
  Problems problems_;
};

}  // namespace tumble
