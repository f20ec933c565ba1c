#include "tumble/report/image.hpp"

#include <gtest/gtest.h>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/formats/testing/scratch_folder.hpp"
#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

std::string picture(const std::string& name) {
  return read_text_file(std::string(TUMBLE_SOURCE_DIR) + "/tests/reference/pictures/" + name);
}

std::string svg(const std::string& attributes) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" " + attributes + "><path d=\"M0 0h9\"/></svg>";
}

std::string with(std::string text, std::size_t place, const std::string& bytes) {
  return text.replace(place, bytes.size(), bytes);
}

Refused refusal_of_file(const std::string& file) {
  return refusal_of([&] { data_uri_of_image_file(file); });
}

TEST(Image, IsKnownByItsFirstBytes) {
  EXPECT_EQ(data_uri_of_image("GIF89a"), "data:image/gif;base64,R0lGODlh");
  EXPECT_EQ(data_uri_of_image("\xff\xd8\xff"), "data:image/jpeg;base64,/9j/");
  EXPECT_TRUE(data_uri_of_image("\x89PNG\r\n\x1a\nxx").starts_with("data:image/png;base64,iVBORw0KGgp4e"));
  EXPECT_TRUE(data_uri_of_image("<?xml version=\"1.0\"?><svg/>").starts_with("data:image/svg+xml;base64,"));
  EXPECT_TRUE(
      data_uri_of_image("\xef\xbb\xbf<!-- > <svg> -->\n<!DOCTYPE svg>\n<svg a=\"1\">").starts_with("data:image/svg"));
  for (const char* other : {"<html>", "<!DOCTYPE html><html><svg></svg></html>", "", "\x89PNG\n\x1a\n"})
    EXPECT_EQ(data_uri_of_image(other), "");
}

TEST(Image, IsSoundAsAWholeAndNoBeginningOfItIs) {
  for (const char* name : {"mark.png", "mark.jpg", "mark_progressive.jpg", "mark.gif"}) {
    const std::string whole = picture(name);
    EXPECT_EQ(fault_of_image(whole), "") << name;
    EXPECT_EQ(fault_of_image(whole + "more"), "") << name;
    const std::size_t last = whole.starts_with("GIF") ? 1 : 0;  // may be missing
    for (std::size_t size = 0; size + last < whole.size(); ++size)
      EXPECT_NE(fault_of_image(whole.substr(0, size)), "") << name << ", " << size;
  }
  const std::string whole = svg("");
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_NE(fault_of_image(whole.substr(0, size)), "") << size;
}

TEST(Image, OfPngIsRefusedWithAnyByteChanged) {
  const std::string whole = picture("mark.png");
  for (std::size_t place = 0; place < whole.size(); ++place)
    EXPECT_NE(fault_of_image(with(whole, place, std::string(1, static_cast<char>(whole[place] ^ 0x10)))), "") << place;
  EXPECT_EQ(fault_of_image(with(whole, 45, "x")), "it is damaged: the checksum of the chunk at byte 33 is wrong");
}

/// Lengths and markers that lead out of the bytes: a fault or none, and no read beyond them.
TEST(Image, WithAnyByteChangedIsReadToItsEndAndNoFurther) {
  for (const std::string& whole :
       {picture("mark.jpg"), picture("mark_progressive.jpg"), picture("mark.gif"), svg("width=\"9\"")}) {
    std::size_t refused = 0;
    for (std::size_t place = 0; place < whole.size(); ++place)
      for (const char byte : {'\0', '\x3b', '\xd9', '\xff'})
        refused += fault_of_image(with(whole, place, std::string(1, byte))).empty() ? 0 : 1;
    EXPECT_GT(refused, 10u);
  }
}

TEST(Image, WithoutASizeIsRefused) {
  const std::string png = picture("mark.png"), jpeg = picture("mark.jpg"), gif = picture("mark.gif");
  const std::string zero = "its width or height is zero";
  EXPECT_EQ(fault_of_image(png.substr(0, 16) + std::string(4, '\0') + png.substr(20, 9) + "\x2f\x78\xa9\x53" +
                           png.substr(33)),
            zero);
  EXPECT_EQ(fault_of_image(with(jpeg, jpeg.find("\xff\xc0") + 5, std::string(2, '\0'))), zero);
  EXPECT_EQ(fault_of_image(with(gif, 8, std::string(2, '\0'))), zero);
  for (const char* attributes :
       {"width=\"0\"", "height=\"0px\"", "viewBox=\"0 0 9 0\"", "viewBox=\"0,0,0,9\"", "width=\"-1\""})
    EXPECT_EQ(fault_of_image(svg(attributes)), zero) << attributes;
  for (const char* attributes :
       {"width=\"100%\"", "width=\"auto\"", "height=\"2em\"", "viewBox=\"-1 -1 .5 4e1\"", "width=\"\""})
    EXPECT_EQ(fault_of_image(svg(attributes)), "") << attributes;
}

TEST(Image, OfSvgIsOneThatBrowsersDraw) {
  EXPECT_NE(fault_of_image("<svg/>"), "");
  EXPECT_NE(fault_of_image("<svg xmlns=\"http://www.w3.org/2000/svg\"><g></svg>"), "");
  EXPECT_EQ(fault_of_image("<svg:svg xmlns:svg=\"http://www.w3.org/2000/svg\"/>"), "");
  EXPECT_EQ(fault_of_image("<?xml version=\"1.0\"?>\n<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.1//EN\" \"svg11.dtd\" [\n"
                           "<!ENTITY ns \"http://www.w3.org/2000/svg\">\n]>\n<svg xmlns=\"&ns;\" width=\"9\"/>"),
            "");
}

TEST(Image, ThatIsRefusedIsNamedWithTheReasonAndWhatIsAccepted) {
  const ScratchFolder folder;
  const auto path = folder.file("logo.png");
  const auto refused = [&](const std::string& bytes) {
    write_file_atomically(path, bytes);
    return refusal_of_file(path);
  };
  const auto fault = [&](const char* part) {
    return Asked{.values = {path}, .part = part, .pattern = "a picture of at most 1 MB"};
  };
  const auto file = Error::Kind::bad_file;
  EXPECT_TRUE(refuses(file, fault("1.2 MB"), refused(picture("mark.png") + std::string(1'200'000, 'x'))));
  EXPECT_TRUE(refuses(file, fault("no picture"), refused("our logo\n")));
  EXPECT_TRUE(refuses(file, fault("empty"), refused("")));
  EXPECT_TRUE(refuses(file, fault("after 50 bytes"), refused(picture("mark.png").substr(0, 50))));
  EXPECT_TRUE(refused(picture("mark.gif")).empty());  // the kind is that of the bytes
  EXPECT_TRUE(refuses(file, Asked{.values = {folder.file("none.png")}, .pattern = "cannot read"},
                      refusal_of_file(folder.file("none.png"))));
}

}  // namespace
}  // namespace tumble
