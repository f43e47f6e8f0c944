//! Tables of suns, good and bad.

use super::*;

fn read(text: &str) -> Result<Vec<SunRow>, SunsError> {
    read_suns(text.as_bytes(), None)
}

fn hours(text: &str) -> Vec<f64> {
    read(text).expect("suns").iter().map(|row| row.duration.as_secs_f64() / 3600.0).collect()
}

#[test]
fn columns_stand_in_any_order() {
    let rows = read("\u{feff}time,hours, elevation ,azimuth\r\n\r\nnoon, 0.5, 61.5 ,180\r\n").expect("suns");
    let place = SunPlace::Angles { azimuth: 180.0, elevation: 61.5 };
    let expected = SunRow { line: 3, place, time: Some("noon".into()), duration: Duration::from_secs(1800) };
    assert_eq!(rows, [expected]);
    let rows = read("z,x,y\n3,1,-2\n").expect("suns");
    assert_eq!(rows[0].place, SunPlace::Direction([1.0, -2.0, 3.0]));
    assert_eq!(rows[0].time, None);
}

#[test]
fn rows_last_for_the_step_of_their_times() {
    let table = |times: &[&str]| {
        times.iter().fold("azimuth,elevation,time\n".to_owned(), |text, time| format!("{text}10,20,{time}\n"))
    };
    let each = |times: &[&str]| hours(&table(times))[0];
    assert_eq!(each(&["9:00", "10:00", "11:00"]), 1.0);
    assert_eq!(each(&["11:00", "9:40", "9:20", "9:00"]), 1.0 / 3.0, "rows in any order, some left out");
    assert_eq!(each(&["2026-06-21T09:00:00", "2026-12-21T09:30:00", "2026-06-21T09:10:00"]), 1.0 / 6.0, "dates");
    assert_eq!(each(&["2026-06-21 09:00:00+02:00", "2026-06-21 09:15:00+02:00"]), 0.25);
    assert_eq!(each(&["2026-06-21T09:00Z"]), 1.0, "one time has no step");
    assert_eq!(each(&["2028-02-29T09:00"]), 1.0, "a leap year");
    assert_eq!(each(&["23:30", "24:00"]), 0.5);
    assert_eq!(each(&["9:00-0330", "9:20-0330"]), 1.0 / 3.0);
    assert_eq!(each(&["24:59", "9:00+banana", "9:00+99:99"]), 1.0, "neither is a time");
    assert_eq!(each(&["morning", "noon"]), 1.0, "labels");
    assert_eq!(hours("x,y,z\n0,-1,0\n0,-1,1\n"), [1.0, 1.0]);
    let said = read_suns(table(&["9:00", "9:10"]).as_bytes(), Some(Duration::from_secs(60))).expect("suns");
    assert_eq!(said[1].duration, Duration::from_secs(60), "what the caller says goes before the times");
    assert_eq!(hours("azimuth,elevation,hours,time\n1,2,0.25,9:00\n1,2,2,9:00\n"), [0.25, 2.0], "and hours before all");
}

/// Who makes a light of a direction refuses what is beyond the accepted range.
#[test]
fn directions_are_taken_as_written() {
    let rows = read("x,y,z\n1e61,-1e-61,1.6e60\n").expect("suns");
    assert_eq!(rows[0].place, SunPlace::Direction([1e61, -1e-61, 1.6e60]));
}

#[test]
fn rows_are_lines_but_for_those_in_quotes() {
    let rows = read("azimuth,elevation,time\r90,10,\"a\nb\"\r\r\n\"91\", 11 ,c\n").expect("reads");
    let told: Vec<_> = rows.iter().map(|row| (row.line, row.time.as_deref().expect("a time"))).collect();
    assert_eq!(told, [(2, "a\nb"), (5, "c")]);
    assert_eq!(rows[1].place, SunPlace::Angles { azimuth: 91.0, elevation: 11.0 });
    let open = read("azimuth,elevation\n90,\"10\n91,11\n").expect_err("refused").to_string();
    assert_eq!(open, "line 2: a quote is not closed");
    let marks = read("azimuth,elevation,time\n90,10,5\" mark\n91,11,noon\n92,12,6\" mark\n93,13,\"a \"\"b\"\"\"\n")
        .expect("reads");
    assert_eq!(marks.iter().map(|row| row.line).collect::<Vec<_>>(), [2, 3, 4, 5]);
    assert_eq!(marks[3].time.as_deref(), Some("a \"b\""));
    let odd = read("azimuth,elevation\n1,\u{1b}[31m\n").expect_err("refused").to_string();
    assert!(odd.contains("\"\\u{1b}[31m\""), "{odd}");
}

#[test]
fn errors_name_the_line() {
    for (text, expected) in [
        ("", "line 1: the header is \"\""),
        ("\n\nazimuth\n1\n", "line 3: the header is \"azimuth\""),
        ("x,y\n", "line 1: the header is \"x,y\""),
        ("azimuth,elevation,x,y,z\n", "line 1: the header is"),
        ("azimuth,elevation,hour\n", "line 1: there is a column \"hour\""),
        ("azimuth,elevation,azimuth\n", "line 1: there are two columns \"azimuth\""),
        ("azimuth,elevation\n\n", "no row follows"),
        ("azimuth,elevation\n1,2\n\n1\n", "line 4: 1 fields"),
        ("azimuth,elevation\n1,high\n", "line 2: elevation is \"high\""),
        ("azimuth,elevation\n1,90.5\n", "line 2: elevation is \"90.5\", not between"),
        ("x,y,z\n1,nan,2\n", "line 2: y is \"nan\""),
        ("x,y,z,hours\n1,-1,2,-1\n", "line 2: hours is \"-1\""),
        ("x,y,z,hours\n1,-1,2,1e7\n", "line 2: hours is \"1e7\""),
        ("x,y,z,time\n1,-1,2,9:00\n1,-1,2,noon\n", "line 3: time is \"noon\", not a time of day"),
        ("x,y,z,time\n1,-1,2,2026-02-28T09:00\n1,-1,2,2026-02-30T09:00\n", "line 3: time is \"2026-02-30T09:00\""),
        ("x,y,z,time\n1,-1,2,9:00\n1,-1,2,9:00\n", "line 3: its time is that of line 2 too"),
        ("x,y,z,time\n1,-1,2,9:00\n1,-1,2,9:10\n1,-1,2,9:25\n", "line 4: its time breaks the step of 600 seconds"),
    ] {
        let message = read(text).expect_err("a defect").to_string();
        assert!(message.contains(expected), "{message} should contain {expected}");
    }
    assert!(matches!(read_suns(&b"x,y,z\n\xff,1,2\n"[..], None), Err(SunsError::Row { line: 2, .. })));
}
