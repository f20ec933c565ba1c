#include "tumble/serve/passwords.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>

#include "tumble/serve/folder_paths.hpp"
#include "tumble/units/error.hpp"
#include "tumble/units/text_parts.hpp"

namespace tumble {
namespace {

constexpr std::size_t shortest = 10, longest = 1000;  ///< bytes of a password
constexpr std::size_t salt_bytes = 16, shortest_salt = 8, key_bytes = 32;

/// Cost of a guess: memory is 128 n r bytes, time grows with n r p.
struct Cost {
  std::uint64_t n = 32768, r = 8, p = 3;
};

struct Hash {
  Cost cost;
  std::string salt, key;  ///< bytes
};

std::string random_bytes(std::size_t count) {
  std::string bytes(count, '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(bytes.data()), static_cast<int>(count)) != 1)
    throw Error{Error::Kind::internal, "the system has no random numbers"};
  return bytes;
}

std::string hex(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(byte));
  return text;
}

/// Nothing where the text is not hex.
std::optional<std::string> unhex(std::string_view text) {
  std::string bytes;
  if (text.size() % 2 != 0) return std::nullopt;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    unsigned value = 0;
    const auto [end, fault] = std::from_chars(text.data() + i, text.data() + i + 2, value, 16);
    if (fault != std::errc{} || end != text.data() + i + 2) return std::nullopt;
    bytes += static_cast<char>(value);
  }
  return bytes;
}

std::string key_of(const std::string& password, const std::string& salt, const Cost& cost) {
  std::string key(key_bytes, '\0');
  const std::uint64_t memory = 128 * cost.r * (cost.n + cost.p) + (std::uint64_t{1} << 20);
  const int made =
      EVP_PBE_scrypt(password.data(), password.size(), reinterpret_cast<const unsigned char*>(salt.data()), salt.size(),
                     cost.n, cost.r, cost.p, memory, reinterpret_cast<unsigned char*>(key.data()), key.size());
  if (made != 1) throw Error{Error::Kind::internal, "scrypt cannot be calculated: there is not enough memory"};
  return key;
}

/// Costs are limited: a file that somebody else wrote must not bring the server down.
std::optional<Hash> parse(const std::string& text) {
  const auto parts = list_items(text, ':');
  if (parts.size() != 6 || parts[0] != "scrypt") return std::nullopt;
  const auto n = as_number<std::uint64_t>(parts[1]), r = as_number<std::uint64_t>(parts[2]),
             p = as_number<std::uint64_t>(parts[3]);
  const auto salt = unhex(parts[4]), key = unhex(parts[5]);
  if (!n || !r || !p || !salt || !key || salt->size() < shortest_salt || key->size() != key_bytes) return std::nullopt;
  if (*n < 16384 || *n > 1048576 || (*n & (*n - 1)) != 0 || *r != 8 || *p < 1 || *p > 16) return std::nullopt;
  return Hash{{*n, *r, *p}, *salt, *key};
}

}  // namespace

std::string hash_of_password(const std::string& password) {
  const Cost cost;
  const std::string salt = random_bytes(salt_bytes);
  return fmt::format("scrypt:{}:{}:{}:{}:{}", cost.n, cost.r, cost.p, hex(salt), hex(key_of(password, salt, cost)));
}

bool is_password(const std::string& password, const std::string& hash) {
  const auto parsed = parse(hash);
  return parsed && equal_in_constant_time(key_of(password, parsed->salt, parsed->cost), parsed->key);
}

bool is_password_hash(const std::string& hash) { return parse(hash).has_value(); }

Problems problems_of_password(const std::string& password, const std::string& user) {
  if (password.size() < shortest)
    return {say("the password is too short: {} characters or more are expected", shortest)};
  if (password.size() > longest) return {say("the password has more than {} bytes", longest)};
  if (!is_plain_name(password)) return {Problem("the password has control characters, or is not in UTF-8")};
  if (password == user) return {Problem("the password is the name of the user")};
  return {};
}

std::string random_secret() { return hex(random_bytes(32)); }

bool equal_in_constant_time(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace tumble
