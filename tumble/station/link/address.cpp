#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "tumble/station/link.hpp"
#include "tumble/units/error.hpp"

namespace tumble {

namespace {

constexpr const char* forms =
    "a link is written tcp:HOST:PORT, udp:HOST:PORT, udp:PORT (to listen) or serial:DEVICE[:BAUD[:8N1]]";

std::optional<long> whole_number(std::string_view text) {
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

void read_port(std::string_view text, LinkAddress& address, Problems& problems) {
  const auto port = whole_number(text);
  if (!port || *port < 1 || *port > 65535)
    return problems.push_back(say("'{}' is not a port, which is a whole number from 1 to 65535", text));
  address.port = static_cast<std::uint16_t>(*port);
}

/// HOST:PORT after "tcp:" or "udp:".
void read_host(std::string_view rest, const char* scheme, LinkAddress& address, Problems& problems) {
  const auto colon = rest.rfind(':');
  std::string_view host = rest.substr(0, colon == std::string_view::npos ? rest.size() : colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  address.host = host;
  if (host.empty()) problems.push_back(say("the host is missing, for example {}:192.168.0.10:4001", Name{scheme}));
  if (colon == std::string_view::npos)
    return problems.push_back(say("the port is missing, for example {}:192.168.0.10:4001", Name{scheme}));
  read_port(rest.substr(colon + 1), address, problems);
}

void read_udp(std::string_view rest, LinkAddress& address, Problems& problems) {
  address.kind = LinkAddress::Kind::udp;
  if (whole_number(rest)) return read_port(rest, address, problems);
  read_host(rest, "udp", address, problems);
}

bool is_framing(std::string_view text) {
  return text.size() == 3 && text[0] >= '5' && text[0] <= '8' &&
         std::string_view("NEO").find(text[1]) != std::string_view::npos && (text[2] == '1' || text[2] == '2');
}

/// DEVICE, DEVICE:BAUD or DEVICE:BAUD:8N1; a device may have colons in its name, as those of /dev/serial/by-path have.
void read_serial(std::string_view rest, LinkAddress& address, Problems& problems) {
  const auto last_part = [&] { return rest.substr(rest.rfind(':') + 1); };
  const auto drop_part = [&] { rest = rest.substr(0, rest.rfind(':')); };
  const bool parts = rest.find(':') != std::string_view::npos;
  if (parts && !whole_number(last_part()) && last_part().find('/') == std::string_view::npos) {
    if (is_framing(last_part()))
      address.framing = last_part();
    else
      problems.push_back(
          say("'{}' is neither a rate such as 921600 nor a framing such as 8N1 (5 to 8 data "
              "bits, parity N, E or O, 1 or 2 stop bits)",
              last_part()));
    drop_part();
  }
  if (rest.find(':') != std::string_view::npos)
    if (const auto baud = whole_number(last_part())) {
      address.baud = *baud;
      if (*baud < 50 || *baud > 20'000'000)
        problems.push_back(say("{} baud is not a rate of a serial line, which is 50 to 20000000", *baud));
      drop_part();
    }
  address.device = rest;
  if (rest.empty()) problems.push_back("the device is missing, for example serial:/dev/ttyUSB0:921600");
}

}  // namespace

LinkAddress parse_link(std::string_view text) {
  LinkAddress address;
  Problems problems;
  if (text.starts_with("tcp:")) {
    read_host(text.substr(4), "tcp", address, problems);
  } else if (text.starts_with("udp:")) {
    read_udp(text.substr(4), address, problems);
  } else if (text.starts_with("serial:")) {
    address.kind = LinkAddress::Kind::serial;
    read_serial(text.substr(7), address, problems);
  } else {
    problems.push_back("it begins with none of tcp:, udp: and serial:");
  }
  if (problems.empty()) return address;
  for (Problem& problem : problems) problem = say("'{}' is not a link: {}", Name{std::string(text)}, problem.what);
  problems.push_back(forms);
  throw Error(Error::Kind::bad_input, problems);
}

std::string text_of(const LinkAddress& address) {
  const bool brackets = address.host.find(':') != std::string::npos, udp = address.kind == LinkAddress::Kind::udp;
  if (udp && address.host.empty()) return fmt::format("udp:{}", address.port);
  if (address.kind != LinkAddress::Kind::serial)
    return fmt::format("{}:{}{}{}:{}", udp ? "udp" : "tcp", brackets ? "[" : "", address.host, brackets ? "]" : "",
                       address.port);
  std::string text = "serial:" + address.device;
  if (address.baud != 0) text += fmt::format(":{}", address.baud);
  if (!address.framing.empty()) text += ":" + address.framing;
  return text;
}

}  // namespace tumble
