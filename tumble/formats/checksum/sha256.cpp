#include "tumble/formats/checksum/sha256.hpp"

#include <openssl/evp.h>

#include <memory>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/file/input_file.hpp"
#include "tumble/math/parallel.hpp"
#include "tumble/units/error.hpp"

namespace tumble::checksum {

namespace {

EVP_MD_CTX* context_of(void* pointer) { return static_cast<EVP_MD_CTX*>(pointer); }

void require(int result) {
  if (result != 1) throw Error{Error::Kind::internal, "libcrypto cannot compute SHA-256"};
}

}  // namespace

void Sha256::Release::operator()(void* context) const { EVP_MD_CTX_free(context_of(context)); }

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  require(EVP_DigestInit_ex(context_of(context_.get()), EVP_sha256(), nullptr));
}

void Sha256::add(std::string_view bytes) {
  require(EVP_DigestUpdate(context_of(context_.get()), bytes.data(), bytes.size()));
}

std::string Sha256::hex() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  require(EVP_DigestFinal_ex(context_of(context_.get()), digest, &size));
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += "0123456789abcdef"[digest[i] >> 4];
    text += "0123456789abcdef"[digest[i] & 15];
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

}  // namespace tumble::checksum

namespace tumble {

std::string sha256_of(std::string_view bytes) {
  checksum::Sha256 sum;
  sum.add(bytes);
  return sum.hex();
}

std::string sha256_of_file(const std::string& path) { return checksum::sha256_of_file(path); }

std::function<std::string()> sha256_in_background(const std::string& path) {
  const auto sum = std::make_shared<std::string>();
  return [sum, done = in_background([sum, path] { *sum = checksum::sha256_of_file(path); }).share()] {
    done.get();
    return *sum;
  };
}

}  // namespace tumble
