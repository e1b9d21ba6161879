#include "experiments/report_page.h"

#include <fmt/format.h>

#include "experiments/html.h"

namespace binpick {
namespace {

constexpr const char* kStyle = R"(
:root{--ink:#1b2430;--soft:#5b6775;--line:#d9dfe6;--ground:#fff;--panel:#f5f7fa;--ours:#2f7ebc;
--paper:#d9822b;--bad:#b3261e;--good:#1f7a3d;
--c0:var(--paper);--c1:var(--ours);--c2:var(--good);--c3:#8a4fb5}
@media(prefers-color-scheme:dark){:root{--ink:#e6ebf1;--soft:#9aa7b5;--line:#33404e;
--ground:#12181f;--panel:#1a222b;--ours:#5aa7e0;--paper:#f0a04b;--bad:#ff8a80;--good:#6fcf97;
--c3:#c39be0}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:80rem;padding:2rem 1.2rem 4rem;background:var(--ground);
color:var(--ink);font:16px/1.5 system-ui,"Segoe UI",Roboto,"Helvetica Neue",sans-serif}
h1{font-size:1.7rem;line-height:1.25;margin:0 0 .3rem}
h2{font-size:1.15rem;margin:2.4rem 0 .7rem;padding-bottom:.25rem;border-bottom:1px solid var(--line)}
p.lead{color:var(--soft);margin:.2rem 0 0}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{padding:.28rem .7rem;text-align:right;white-space:nowrap;border-bottom:1px solid var(--line)}
th{font-weight:600;color:var(--soft);font-size:.87rem}
td.text,th.text{text-align:left}
td.note{white-space:normal;text-align:left;min-width:14rem}
.rates th,.rates td{padding:.28rem .42rem}.rates th{white-space:normal}
svg.bar{display:block}
svg .grid{stroke:var(--line)}
svg .ours{fill:var(--ours)}
svg .whisker{stroke:var(--ink);stroke-width:1.6}
svg .paper{fill:var(--paper);stroke:var(--ground)}
svg text{fill:var(--soft);font-size:10px;paint-order:stroke;stroke:var(--ground);stroke-width:3px;
stroke-linejoin:round}
.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(17rem,100%),1fr));gap:1rem}
svg.plot{width:100%;max-width:30rem;height:auto}
svg .title{font-size:12px;font-weight:600;fill:var(--ink)}
svg .mark{stroke:var(--soft);stroke-dasharray:2 3}
.good{color:var(--good)}.bad{color:var(--bad);font-weight:600}
code,pre{font:.84rem/1.45 ui-monospace,"SF Mono",Menlo,Consolas,monospace}
pre{background:var(--panel);padding:1rem;overflow-x:auto;border-radius:.4rem}
details{margin:.4rem 0}summary{cursor:pointer}
td code{background:var(--panel);padding:.1rem .35rem;border-radius:.25rem;user-select:all}
ul{padding-left:1.2rem}
a{color:var(--ours)}
th.text{white-space:normal;min-width:8rem}
.maps{display:flex;flex-wrap:wrap;gap:1.5rem}
table.map th:first-child{white-space:normal;max-width:9rem}table.map caption{text-align:left;color:var(--soft);padding-bottom:.3rem}
table.map td{text-align:center;min-width:2.8rem;
background:color-mix(in srgb,color-mix(in srgb,var(--ours) var(--rate),var(--paper)) 45%,transparent)}
h3{font-size:1rem;margin:1.6rem 0 .4rem}
article{break-inside:avoid}article p{margin:.3rem 0}
article code{background:var(--panel);padding:.1rem .35rem;border-radius:.25rem;user-select:all;
overflow-wrap:anywhere}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(14rem,1fr));gap:.6rem}
figure{margin:0}figure img{display:block;width:100%;border-radius:.3rem}
figcaption{font-size:.8rem;color:var(--soft)}
#replay canvas{display:block;width:100%;aspect-ratio:16/9;border-radius:.4rem}
#replay .controls{display:flex;flex-wrap:wrap;align-items:center;gap:.6rem;margin:.6rem 0}
#replay input[type=range]{flex:1 1 12rem;min-width:8rem}
#replay button,#replay select{font:inherit;padding:.25rem .7rem;max-width:100%}
#replay button{min-width:5rem}
#replay output{font-variant-numeric:tabular-nums}
#replay svg{display:block;width:100%;height:70px;background:var(--panel);cursor:pointer}
#replay svg *{vector-effect:non-scaling-stroke}
#replay .force{fill:none;stroke:var(--bad)}
#replay .tick{stroke:var(--soft)}#replay .cursor{stroke:var(--ink)}
#replay .note{min-height:1.5em;margin:.3rem 0;color:var(--soft)}
@media print{body{max-width:none;padding:0;font-size:11px}h2,h3{break-after:avoid}
.wide{overflow:visible}th,td{padding:.15rem .3rem;font-size:9px}th{white-space:normal}
svg.plot{max-width:15rem}.plots{grid-template-columns:repeat(3,1fr)}svg.bar{width:80px;height:auto}
.pictures{grid-template-columns:repeat(4,1fr)}code,pre{font-size:8px}
pre{white-space:pre-wrap;columns:3;padding:.5rem}
#replay .controls,#replay label,#replay p:last-child{display:none}}
)";

}  // namespace

std::string report_page(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
      "<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{2}</body>\n</"
      "html>\n",
      html_escape(title), kStyle, body);
}

}  // namespace binpick
