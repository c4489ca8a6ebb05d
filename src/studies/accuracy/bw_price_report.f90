module bw_price_report
  !! The printed report on the cost of accuracy.
  use bw_kinds, only: dp
  use bw_absent_effects, only: absent_words
  use bw_columns, only: right, short, table_of, text_table
  use bw_missing, only: is_missing
  use bw_price_list, only: beyond_model, by_counts, by_tolerances, digit_noise, method_words, price_digits, &
    price_list, priced_stages, rung_out_of_reach, rung_too_long, rung_type, what_is_bounded, &
    & work_slope
  use bw_stopwatch, only: processor_name
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: price_report

contains

  function price_report(list) result(text)
    !! Return the tables of the study as printed.
    type(price_list), intent(in) :: list
    character(:), allocatable :: text
    type(text_builder) :: lines
    call lines%append_line('')
    call report_converged(list, lines)
    call lines%append_line('')
    call lines%append_line('  Run on '//processor_name()//'; medians of the repeats, +/- half their interquartile range')
    call report_ladder(list, by_tolerances, 'tolerance', lines)
    call report_ladder(list, by_counts, 'before = after (the time of the error estimate is part of response here, of modes '// &
                       'above)', lines)
    call report_slopes(list, lines)
    call report_model(list, lines)
    text = lines%text()
  end function price_report

  subroutine report_converged(list, lines)
    !! Report the reference of the errors.
    type(price_list), intent(in) :: list
    type(text_builder), intent(inout) :: lines
    call lines%append_line('  Errors are the largest of '//what_is_bounded(list)//' over its peak'//peak_text()//', against a')
    call lines%append_line('  converged run of '//text_of(list%converged_count)//' modes, tolerance '// &
                           shortest(list%converged_tolerance, 2)//', whose own error is estimated at '// &
                           short(list%converged_error)//';')
    call lines%append_line('  smaller errors are shown as <')
  contains
    function peak_text() result(text)
      !! Return the peak of the displacement as text.
      character(:), allocatable :: text
      text = ', '//shortest(list%peak, 4)//' m'
      if (list%bounds_all) text = ' (displacement:'//text(2:)//')'
    end function peak_text
  end subroutine report_converged

  subroutine report_model(list, lines)
    !! Report the tolerance below which the modelling error exceeds the numerical one.
    type(price_list), intent(in) :: list
    type(text_builder), intent(inout) :: lines
    integer :: largest, i
    largest = maxloc(list%model_errors, dim=1)
    if (is_missing(list%model_errors(largest)) .or. list%model_errors(largest) == 0.0_dp) return
    call lines%append_line('')
    call lines%append_line('  The model: '//trim(absent_words(largest))//', which the scene leaves out, would change the '// &
                           'displacement by about '//shortest(list%model_errors(largest), 2))
    i = findloc(list%rungs%ladder == by_tolerances .and. beyond_model(list%rungs, list%model_errors(largest)), .true., &
                dim=1)
    if (i == 0) then
      call lines%append_line('  times its peak (estimated). No tolerance has a true error as small as that.')
    else
      call lines%append_line('  times its peak (estimated). From tolerance '//shortest(list%rungs(i)%tolerance, 2)// &
                             ' on the numerical error is smaller than the model''s.')
    end if
  end subroutine report_model

  subroutine report_ladder(list, ladder, title, lines)
    !! Print the rungs of one ladder, if it has any.
    type(price_list), intent(in) :: list
    integer, intent(in) :: ladder
    character(*), intent(in) :: title
    type(text_builder), intent(inout) :: lines
    real(dp), dimension(size(list%rungs)) :: seconds, growth, noise
    type(text_table) :: table
    integer :: i
    if (.not. any(list%rungs%ladder == ladder)) return
    call price_digits(list%rungs, seconds, growth)
    noise = digit_noise(list%rungs)
    call lines%append_line('')
    call lines%append_line('  '//title)
    table = table_of('|modes|summed by|true error|estimate|ratio|ms|+/-|modes|events|response|next digit', '', &
                     [11, 11, 11, 12, 10, 7, 10, 7, 7, 8, 10, 18], is_list=.false.)
    if (ladder == by_tolerances) call table%put_head(lines)
    do i = 1, size(list%rungs)
      if (list%rungs(i)%ladder /= ladder) cycle
      call put_rung(list, list%rungs(i), table, next_text(seconds(i), growth(i), noise(i)), lines)
    end do
  end subroutine report_ladder

  subroutine put_rung(list, rung, table, next, lines)
    !! Print the line of a rung.
    type(price_list), intent(in) :: list
    type(rung_type), intent(in) :: rung
    type(text_table), intent(in) :: table
    character(*), intent(in) :: next               !! cost of the next digit
    type(text_builder), intent(inout) :: lines
    character(:), allocatable :: cells
    integer :: i
    cells = shortest(rung%tolerance, 2)
    if (rung%ladder == by_counts) cells = text_of(rung%mode_count)
    if (is_missing(rung%seconds)) then
      call table%put_row(lines, cells, '  '//reason(list, rung)//next)
      return
    end if
    cells = cells//'|'//text_of(rung%mode_count)//'|'//trim(method_words(rung%method))//'|'// &
      error_text(rung%error, list%converged_error)//'|'//short(rung%estimate)//'|'//ratio_text(rung, list%converged_error)//'|'// &
      milliseconds(rung%seconds)//'|'//milliseconds(0.5_dp*(rung%upper - rung%lower))
    do i = 1, priced_stages
      cells = cells//'|'//percent(rung%stages(i)/sum(rung%stages))
    end do
    call table%put_row(lines, cells, next)
  end subroutine put_rung

  pure function reason(list, rung) result(text)
    !! Return the words that replace a rung's numbers if it was not run.
    type(price_list), intent(in) :: list
    type(rung_type), intent(in) :: rung
    character(:), allocatable :: text
    select case (rung%status)
    case (rung_out_of_reach)
      text = 'out of reach'
      if (.not. is_missing(list%reachable)) text = text//'; '//shortest(list%reachable, 2)//' can be reached'
    case (rung_too_long)
      text = 'left out: it would take too long'
    case default
      text = 'the motion overflows'
    end select
  end function reason

  subroutine report_slopes(list, lines)
    !! Report the cost of a further digit, by a straight line through all errors.
    type(price_list), intent(in) :: list
    type(text_builder), intent(inout) :: lines
    real(dp) :: slope
    real(dp), dimension(size(list%rungs)) :: seconds, growth
    call price_digits(list%rungs, seconds, growth)
    call lines%append_line('')
    slope = work_slope(list%rungs, by_tolerances, list%converged_error)
    call lines%append(slope_words('By tolerance', slope))
    if (.not. is_missing(slope)) call lines%append(', and at the steepest step '// &
      times_words(1.0_dp + maxval(growth, mask=.not. is_missing(growth))))
    call lines%append_line('')
    call lines%append_line(slope_words('By counts', work_slope(list%rungs, by_counts, list%converged_error)))
  end subroutine report_slopes

  pure function slope_words(ladder, slope) result(words)
    !! Report the cost of a tenth of the error on a ladder, by its slope.
    character(*), intent(in) :: ladder
    real(dp), intent(in) :: slope                 !! missing: unknown
    character(:), allocatable :: words
    if (is_missing(slope)) then
      words = '  '//ladder//' the errors differ too little to say how long a tenth of them takes'
    else
      words = '  '//ladder//' a tenth of the error takes '//times_words(10.0_dp**(-slope))//' as long (seconds ~ error^'// &
        shortest(slope, 2)//')'
    end if
  end function slope_words

  pure function times_words(factor) result(words)
    real(dp), intent(in) :: factor
    character(:), allocatable :: words
    words = shortest(factor, 2)//' times'
  end function times_words

  pure function next_text(seconds, growth, noise) result(text)
    !! Return the columns on the cost of the next digit; empty if unknown.
    real(dp), intent(in) :: seconds, growth, noise
    character(:), allocatable :: text
    text = ''
    if (is_missing(seconds)) return
    text = right('within noise', 18)
    if (seconds <= noise) return       ! also if negative: a finer tolerance never sums fewer modes
    text = right('+'//milliseconds(seconds)//' ms', 11)//right('+'//percent(growth), 7)
  end function next_text

  pure function error_text(error, least) result(text)
    !! Format a true error; below that of the converged run only this bound is known.
    real(dp), intent(in) :: error, least
    character(:), allocatable :: text
    if (.not. is_missing(error) .and. error <= least .and. least > 0.0_dp) then
      text = '<'//short(least)
    else
      text = short(error)
    end if
  end function error_text

  pure function ratio_text(rung, least) result(text)
    !! Format the estimate over the true error; a dash if that is not resolved.
    type(rung_type), intent(in) :: rung
    real(dp), intent(in) :: least
    character(:), allocatable :: text
    text = '-'
    if (is_missing(rung%estimate) .or. is_missing(rung%error)) return
    if (rung%error > least) text = shortest(rung%estimate/rung%error, 2)
  end function ratio_text

  pure function milliseconds(seconds) result(text)
    !! Format seconds as milliseconds with three digits.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    text = shortest(1000.0_dp*seconds, 3)
  end function milliseconds

  pure function percent(part) result(text)
    !! Format a fraction in whole per cent.
    real(dp), intent(in) :: part
    character(:), allocatable :: text
    text = text_of(nint(100.0_dp*min(part, 1.0e6_dp)))//' %'
  end function percent

end module bw_price_report
