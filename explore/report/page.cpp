#include "report/page.h"

#include <string_view>

// Files of report/web and the chart library become part of the program as they are.
#define PAVESCAPE_EMBED(name, file)                                                                                    \
    __asm__(".section .rodata\n.global " #name "_begin\n.global " #name "_end\n" #name "_begin:\n.incbin \"" file      \
            "\"\n" #name "_end:\n.previous\n");                                                                        \
    extern "C" const char name##_begin[];                                                                              \
    extern "C" const char name##_end[]

PAVESCAPE_EMBED(pavescape_script, PAVESCAPE_WEB "/report.js");
PAVESCAPE_EMBED(pavescape_words, PAVESCAPE_WEB "/words.js");
PAVESCAPE_EMBED(pavescape_summary, PAVESCAPE_WEB "/summary.js");
PAVESCAPE_EMBED(pavescape_design, PAVESCAPE_WEB "/design.js");
PAVESCAPE_EMBED(pavescape_road, PAVESCAPE_WEB "/road.js");
PAVESCAPE_EMBED(pavescape_landscape, PAVESCAPE_WEB "/landscape.js");
PAVESCAPE_EMBED(pavescape_blocks, PAVESCAPE_WEB "/blocks.js");
PAVESCAPE_EMBED(pavescape_style, PAVESCAPE_WEB "/report.css");
PAVESCAPE_EMBED(pavescape_explore, PAVESCAPE_WEB "/explore.js");
PAVESCAPE_EMBED(pavescape_explore_style, PAVESCAPE_WEB "/explore.css");
PAVESCAPE_EMBED(pavescape_charts, PAVESCAPE_CHARTS);

namespace explore::report {
namespace {

std::string_view text(const char* begin, const char* end) {
    return {begin, static_cast<std::size_t>(end - begin)};
}

// JSON that no parser of HTML takes for anything else.
std::string harmless(const Json& data) {
    std::string safe;
    for (const char c : data.dump(-1, ' ', false, Json::error_handler_t::replace)) {
        if (c == '<') {
            safe += "\\u003c"; // only within strings
        } else {
            safe += c;
        }
    }
    return safe;
}

// policy: what it may besides drawing itself; style: besides that of the report.
std::string document(std::string_view title, std::string_view policy, std::string_view style, std::string_view body,
                     std::string_view script) {
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                       "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src "
                       "'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:";
    html += policy;
    html += "\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
            "<link rel=\"icon\" href=\"data:,\">\n<title>";
    html += title;
    html += "</title>\n<style>";
    html += text(pavescape_style_begin, pavescape_style_end);
    html += style;
    html += "</style>\n</head>\n<body>\n";
    html += body;
    html += "\n<script>";
    html += text(pavescape_charts_begin, pavescape_charts_end);
    html += "</script>\n<script>";
    html += text(pavescape_words_begin, pavescape_words_end);
    html += text(pavescape_blocks_begin, pavescape_blocks_end);
    html += script;
    html += "</script>\n</body>\n</html>\n";
    return html;
}

} // namespace

std::string page(const Json& data) {
    return document("Pavescape report", "", "",
                    "<main id=\"report\"><noscript>This report draws itself: allow its own script.</noscript></main>\n"
                    "<script type=\"application/json\" id=\"data\">" +
                        harmless(data) + "</script>",
                    std::string(text(pavescape_landscape_begin, pavescape_landscape_end)) +
                        std::string(text(pavescape_summary_begin, pavescape_summary_end)) +
                        std::string(text(pavescape_design_begin, pavescape_design_end)) +
                        std::string(text(pavescape_road_begin, pavescape_road_end)) +
                        std::string(text(pavescape_script_begin, pavescape_script_end)));
}

std::string explore_page() {
    return document("Pavescape explore", "; connect-src 'self'",
                    text(pavescape_explore_style_begin, pavescape_explore_style_end),
                    "<main id=\"explore\"><noscript>This page draws itself: allow its own script.</noscript></main>",
                    text(pavescape_explore_begin, pavescape_explore_end));
}

} // namespace explore::report
