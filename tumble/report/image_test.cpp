#include "tumble/report/image.hpp"

#include <gtest/gtest.h>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/error.hpp"

namespace tumble {
namespace {

TEST(Image, IsKnownByItsFirstBytes) {
  EXPECT_EQ(data_uri_of_image("GIF8ab"), "data:image/gif;base64,R0lGOGFi");
  EXPECT_EQ(data_uri_of_image("\xff\xd8\xff"), "data:image/jpeg;base64,/9j/");
  EXPECT_TRUE(data_uri_of_image("\x89PNG\r\n\x1a\nxx").starts_with("data:image/png;base64,iVBORw0KGgp4e"));
  EXPECT_TRUE(data_uri_of_image("<?xml version=\"1.0\"?><svg/>").starts_with("data:image/svg+xml;base64,"));
  EXPECT_TRUE(
      data_uri_of_image("\xef\xbb\xbf<!-- > <svg> -->\n<!DOCTYPE svg>\n<svg a=\"1\">").starts_with("data:image/svg"));
  EXPECT_EQ(data_uri_of_image("<html>"), "");
  EXPECT_EQ(data_uri_of_image("<!DOCTYPE html><html><svg></svg></html>"), "");
  EXPECT_EQ(data_uri_of_image(""), "");
}

TEST(Image, OfAnotherKindOrTooLargeIsRefused) {
  const ScratchFolder folder;
  const auto path = folder.file("logo.png");
  write_file_atomically(path, "GIF8" + std::string(1'000'000, 'x'));
  EXPECT_THROW(data_uri_of_image_file(path), Error);
  write_file_atomically(path, "BM");
  EXPECT_THROW(data_uri_of_image_file(path), Error);
  EXPECT_THROW(data_uri_of_image_file(folder.file("none.png")), Error);
}

}  // namespace
}  // namespace tumble
