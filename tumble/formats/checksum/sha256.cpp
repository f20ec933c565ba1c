// The functions of SHA-256 themselves: EVP_DigestInit would need all of libcrypto, a fifth of the wheel (decision 068).
#include "tumble/formats/sha256.hpp"

#include <openssl/sha.h>

#include <memory>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace tumble {

namespace {

SHA256_CTX* context_of(void* pointer) { return static_cast<SHA256_CTX*>(pointer); }

void require(int result) {
  if (result != 1) throw Error{Error::Kind::internal, "libcrypto cannot compute SHA-256"};
}

}  // namespace

void Sha256::Release::operator()(void* context) const { delete context_of(context); }

Sha256::Sha256() : context_(new SHA256_CTX) { require(SHA256_Init(context_of(context_.get()))); }

void Sha256::add(std::string_view bytes) {
  require(SHA256_Update(context_of(context_.get()), bytes.data(), bytes.size()));
}

std::string Sha256::hex() {
  unsigned char digest[SHA256_DIGEST_LENGTH];
  require(SHA256_Final(digest, context_of(context_.get())));
  std::string text;
  for (const unsigned char byte : digest) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

std::string sha256_of_file(const std::string& path) {
  file::InputFile file(path);
  Sha256 hash;
  std::string block(std::size_t{1} << 18, '\0');
  while (const std::size_t count = file.read(block.data(), block.size())) hash.add({block.data(), count});
  return hash.hex();
}

std::string sha256_of(std::string_view bytes) {
  Sha256 sum;
  sum.add(bytes);
  return sum.hex();
}

std::function<std::string()> sha256_in_background(const std::string& path) {
  const auto sum = std::make_shared<std::string>();
  return [sum, done = in_background([sum, path] { *sum = sha256_of_file(path); }).share()] {
    done.get();
    return *sum;
  };
}

}  // namespace tumble

#pragma GCC diagnostic pop
