#include "tumble/station/lease/names.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>

#include "tumble/station/link.hpp"
#include "tumble/units/error.hpp"

namespace tumble::lease {

namespace {

std::string text_of_ipv4(const in_addr& address) {
  char text[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &address, text, sizeof text);
  return std::string(text) == "0.0.0.0" ? "127.0.0.1" : text;  // the own machine
}

std::string text_of_ipv6(const sockaddr_in6& end) {
  if (IN6_IS_ADDR_V4MAPPED(&end.sin6_addr)) {
    in_addr inner{};
    std::copy_n(end.sin6_addr.s6_addr + 12, 4, reinterpret_cast<unsigned char*>(&inner.s_addr));
    return text_of_ipv4(inner);
  }
  char text[INET6_ADDRSTRLEN] = "";
  inet_ntop(AF_INET6, &end.sin6_addr, text, sizeof text);
  const std::string whole = std::string(text) == "::" ? "::1" : text;
  return end.sin6_scope_id == 0 ? fmt::format("[{}]", whole) : fmt::format("[{}%{}]", whole, end.sin6_scope_id);
}

std::string text_of_end(const sockaddr& end) {
  if (end.sa_family == AF_INET) return text_of_ipv4(reinterpret_cast<const sockaddr_in&>(end).sin_addr);
  if (end.sa_family == AF_INET6) return text_of_ipv6(reinterpret_cast<const sockaddr_in6&>(end));
  return "";
}

std::vector<std::string> names_of_tcp(const LinkAddress& address) {
  addrinfo wanted{}, *first = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  if (getaddrinfo(address.host.c_str(), nullptr, &wanted, &first) != 0) return {text_of(address)};
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> all(first, freeaddrinfo);
  std::vector<std::string> names;
  for (const addrinfo* one = first; one != nullptr; one = one->ai_next)
    if (const std::string end = text_of_end(*one->ai_addr); !end.empty())
      names.push_back(fmt::format("tcp:{}:{}", end, address.port));
  return names.empty() ? std::vector{text_of(address)} : names;
}

/// What follows the word for a serial number, in small letters and digits: "12" of "SN 12"; empty: nothing with a
/// digit.
std::string serial_number_in(const std::string& identity) {
  std::string text;
  for (const char c : identity) text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  for (const std::string word : {"serial", "s/n", "sn"}) {
    const auto at = text.find(word);
    if (at == std::string::npos || (at > 0 && is_word(text[at - 1]))) continue;
    std::string number;
    for (const char c : text.substr(at + word.size()))
      if (is_word(c)) number += c;
    if (std::ranges::any_of(number, [](char c) { return '0' <= c && c <= '9'; })) return number;
  }
  return "";
}

bool is_on_this_computer(const std::string& name) {
  return name.starts_with("tcp:127.") || name.starts_with("tcp:[::1]");
}

std::string name_of_serial(const LinkAddress& address) {
  struct stat device {};
  if (stat(address.device.c_str(), &device) == 0 && S_ISCHR(device.st_mode))
    return fmt::format("serial:{}:{}", major(device.st_rdev), minor(device.st_rdev));
  std::error_code problem;
  const auto path = std::filesystem::weakly_canonical(address.device, problem);
  return "serial:" + (problem ? address.device : path.string());
}

}  // namespace

std::vector<std::string> names_of_link(const std::string& link) {
  std::vector<std::string> names;
  try {
    const LinkAddress address = parse_link(link);
    if (address.kind == LinkAddress::Kind::tcp) names = names_of_tcp(address);
    if (address.kind == LinkAddress::Kind::serial) names = {name_of_serial(address)};
  } catch (const Error&) {  // whoever opens the link says what is wrong with it
  }
  if (names.empty()) names = {link};
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::vector<std::string> names_of_device(const StationDevice& device) {
  if (device.link.empty()) return {};
  std::vector<std::string> names = names_of_link(device.link);
  const std::string number = serial_number_in(device.identity);
  if (!number.empty() && std::ranges::none_of(names, is_on_this_computer))
    names.push_back(
        fmt::format("serial number:{}:{}", std::filesystem::path(device.controller).stem().string(), number));
  return names;
}

}  // namespace tumble::lease
