//! Tests of the reader on small files.

use super::*;

fn file(body: &str) -> String {
    format!("<?xml version=\"1.0\"?>\n<OpenDRIVE><header/>\n{body}\n</OpenDRIVE>\n")
}

const ROAD: &str = r#"<road id="main" length="10" junction="-1" rule="LHT">
 <link><predecessor elementType="junction" elementId="J"/><successor elementType="road" elementId="b" contactPoint="end"/></link>
 <type s="0" type="town"><speed max="30" unit="mph"/></type>
 <planView><geometry s="0" x="1" y="2" hdg="0" length="10"><line/></geometry></planView>
 <lanes>
  <laneSection s="0">
   <left><lane id="1" type="driving"><link><successor id="2"/></link><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
   <center><lane id="0"><roadMark sOffset="0" type="solid" color="yellow"/></lane></center>
   <right><lane id="-1" type="bidirectional"><width sOffset="0" a="3" b="0" c="0" d="0"/><speed sOffset="5" max="10"/></lane></right>
  </laneSection>
 </lanes>
 <objects><object id="o" type="crosswalk" s="5" t="0" hdg="0" length="4" width="2"/></objects>
 <signals><signal id="s" s="9" t="-4" type="206" orientation="+" dynamic="no"><validity fromLane="-1" toLane="-2"/></signal></signals>
</road>"#;

#[test]
fn a_road_is_read_with_all_that_belongs_to_it() {
    let read = read(&file(ROAD)).unwrap();
    assert!(read.oddities.is_empty(), "{:?}", read.oddities);
    let road = &read.roads[0];
    assert_eq!((road.id.as_str(), road.line, road.left_hand), ("main", 3, true));
    assert_eq!(road.links[0], Some(RoadLink::Junction("J".into())));
    assert_eq!(road.links[1], Some(RoadLink::Road("b".into(), Some(RoadEnd::End))));
    let section = &road.sections[0];
    assert_eq!(section.lanes.iter().map(|lane| lane.id).collect::<Vec<_>>(), [1, -1]);
    assert_eq!(section.lane(1).unwrap().links[1], [2]);
    assert_eq!(section.mark(0, 3.0).unwrap().color, "yellow");
    let limits = [4.0, 6.0].map(|at| road.speed(section, section.lane(-1).unwrap(), at).unwrap());
    assert!((limits[0] - 48.28).abs() < 0.01 && (limits[1] - 36.0).abs() < 0.01, "{limits:?}");
    let signal = &road.signals[0];
    assert!(signal.validity.facing == 1 && signal.validity.names(-2) && !signal.validity.names(1));
    let ring = road.objects[0].ring(road).unwrap();
    assert_eq!(ring[0], [4.0, 1.0, 0.0]);
}

#[test]
fn a_comment_may_stand_before_the_declaration() {
    let text = format!("<!-- made by hand -->\n{}", file(ROAD));
    assert!(is_opendrive(text.as_bytes()));
    assert_eq!(read(&text).unwrap().roads[0].line, 4);
    assert!(!is_opendrive(b"<osm/>") && !is_opendrive(b"{\"<OpenDRIVE\": 1}"));
}

#[test]
fn what_is_odd_is_told_with_its_line() {
    let nan = ROAD.replace("hdg=\"0\" length=\"10\"", "hdg=\"NaN\" length=\"10\"");
    let bare = "<road id=\"main\" length=\"5\"/>";
    let read = read(&file(&format!("{nan}\n{bare}"))).unwrap();
    let told: Vec<(usize, bool)> = read.oddities.iter().map(|it| (it.line, it.message.contains("main"))).collect();
    assert_eq!(told, [(6, false), (17, true), (17, true)], "{:?}", read.oddities);
    assert_eq!(read.roads.len(), 1);
}

#[test]
fn damage_is_an_error_with_its_place() {
    let whole = file(ROAD);
    let cut = &whole[..whole.len() / 2];
    assert!(matches!(read(cut), Err(XodrError::CutOff { .. } | XodrError::Broken { .. })), "{:?}", read(cut).err());
    let wrong = whole.replace("</planView>", "</planViev>");
    let error = read(&wrong).unwrap_err();
    assert!(error.offset() > 100 && matches!(error, XodrError::Broken { .. }), "{error}");
    assert_eq!(read("<osm/>").unwrap_err(), XodrError::NoRoot);
    let deep = format!("<OpenDRIVE>{}", "<a>".repeat(100_000));
    assert!(matches!(read(&deep), Err(XodrError::TooMuch { .. })));
}
