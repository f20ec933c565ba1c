#include "tumble/formats/file/mapping.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "tumble/formats/checksum.hpp"
#include "tumble/formats/testing/log_files.hpp"

namespace tumble::file {
namespace {

std::string some_bytes(std::size_t count) {
  std::string bytes(count, '\0');
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<char>(i * 7 + i / 251);
  return bytes;
}

TEST(Mapping, HoldsTheBytesOfTheFile) {
  const ScratchFolder folder;
  const std::string bytes = some_bytes(300'000);
  write_bytes(folder.file("a"), bytes);
  const InputFile file(folder.file("a"));
  for (const std::size_t offset : {0u, 1u, 65'535u, 65'536u, 299'999u}) {
    const Mapping mapping(file, offset, bytes.size() - offset);
    if (mapping.at(offset) == nullptr) GTEST_SKIP() << "this system does not map files";
    EXPECT_EQ(std::string_view(mapping.at(offset), bytes.size() - offset), std::string_view(bytes).substr(offset));
    EXPECT_EQ(mapping.at(bytes.size()), nullptr);
  }
  EXPECT_EQ(Mapping(file, 0, bytes.size() + 1).at(0), nullptr);  // behind the end
  EXPECT_EQ(Mapping(file, 0, 0).at(0), nullptr);
}

// Whoever wants to shorten the file waits until the lease is given back, and then does so.
TEST(Mapping, ALeaseKeepsTheFileAsLongAsItIs) {
  const ScratchFolder folder;
  const std::string path = folder.file("a"), bytes = some_bytes(300'000);
  write_bytes(path, bytes);
  const auto file = std::make_shared<InputFile>(path);
  Lease lease(file);
  if (!lease.holds()) GTEST_SKIP() << "this system gives no lease";
  std::atomic<bool> shortened = false;
  std::thread other([&] {
    std::ofstream(path, std::ios::trunc) << "short";
    shortened = true;
  });
  while (lease.holds()) {
    const Mapping mapping(*file, 0, bytes.size());
    ASSERT_NE(mapping.at(0), nullptr);
    EXPECT_EQ(std::string_view(mapping.at(0), bytes.size()), bytes);
    EXPECT_FALSE(shortened);
  }
  other.join();
  EXPECT_FALSE(lease.holds());
  EXPECT_EQ(read_text_file(path), "short");
}

TEST(Mapping, AFileThatIsOpenForWritingIsCopied) {
  const ScratchFolder folder;
  const std::string path = folder.file("a"), bytes = some_bytes(9 << 20);
  std::ofstream writer(path, std::ios::binary);
  writer << bytes << std::flush;
  EXPECT_FALSE(Lease(std::make_shared<InputFile>(path)).holds());
  EXPECT_EQ(sha256_of_file(path), sha256_of(bytes));
}

TEST(Mapping, TheChecksumOfAFileIsThatOfItsBytes) {
  const ScratchFolder folder;
  for (const std::size_t size : {0u, 1u, 4096u, 4u << 20, (4u << 20) + 1, 9u << 20}) {
    const std::string bytes = some_bytes(size);
    write_bytes(folder.file("a"), bytes);
    EXPECT_EQ(sha256_of_file(folder.file("a")), sha256_of(bytes)) << size;
  }
}

}  // namespace
}  // namespace tumble::file
